"""Left out: an effect of the catalogue that the engine is not given, nor others that say the same of such recordings.

What is then missing has no name: the right answer is "unknown", with what it depends on.
"""

from dataclasses import dataclass
from typing import Any

LEFT_OUT = "left out"  # drawn only when asked for


@dataclass(frozen=True)
class Withheld:
    """Attributes:
    variables: on which the effect depends, as one who does not know it can say it.
    with_it: entries of the catalogue that a law of this form may be, though the generator has none of them.
    """

    variables: tuple[str, ...]
    with_it: tuple[str, ...] = ()


# a map of the image, free at every pixel, is a right description of a law of the image
MAPS = ("fixed_pattern", "disparity_distortion")
# those that act on what is next to a pixel, or on nothing at all, have no variables that anyone could tell
WITHHELD = {
    "cyclic_error": Withheld(("depth",), ("depth_quantization", "phase_wrapping")),
    "amplitude_error": Withheld(("amplitude",), ("pixel_crosstalk", "sensor_interference")),
    "column_delay": Withheld(("u",), (*MAPS, "principal_point")),
    "emitter_parallax": Withheld(("u", "depth"), MAPS),
    "fixed_pattern": Withheld(("u", "v"), MAPS),
    "temperature_drift": Withheld(("time",), ("projector_thermal_drift",)),
    "depth_scale": Withheld(("depth",), ("focal_length",)),
    "disparity_offset": Withheld(("depth",), ("depth_offset",)),
    "vertical_banding": Withheld(("u",), MAPS),
    "pixel_locking": Withheld(("depth",), ("depth_quantization",)),
    "disparity_distortion": Withheld(("u", "v"), (*MAPS, "vertical_banding", "lens_distortion")),
}


def as_left_out(label: dict[str, Any]) -> dict[str, Any]:
    """The label of a case of one effect, where that effect and its equivalents are withheld from the engine."""
    truth, *_ = label["missing"]
    name = truth["effect"]
    withheld = sorted({name, *truth["accept"], *label["equivalent"], *WITHHELD[name].with_it})
    unnamed = {**truth, "effect": "unknown", "accept": [], "variables": list(WITHHELD[name].variables), "similar": {}}
    unnamed.pop("parameters", None)
    return {**label, "missing": [unnamed], "equivalent": [], "withheld": withheld}
