"""Which cases a seed has: 30 % where nothing is missing, 17 % with two effects, the others with one."""

from dataclasses import dataclass

import numpy as np

from tools.trial.furnished.planted.catalogue import FLIGHT, MATCHING

NULLS = ["plain"] * 4 + ["moved thing", "poses noisier", "bowed board", "plain", "stated fattening", "poses noisier"]
NULLS += ["moved thing", "zone", "plain", "warm-up told, no drift"]
TOLD_APART = {  # effects of which two together can be told from each other
    "itof": [
        "depth_offset",
        "cyclic_error",
        "stray_light",
        "fixed_pattern",
        "temperature_drift",
        "lens_distortion",
        "amplitude_error",
        "saturation",
        "axial_noise",
        "depth_scale",
        "column_delay",
        "subsurface_scattering",
    ],
    "tri": [
        "disparity_offset",
        "vertical_banding",
        "pixel_locking",
        "lens_distortion",
        "axial_noise",
        "temperature_drift",
        "edge_fattening",
        "depth_quantization",
        "disparity_distortion",
    ],
}
EASY = ["cyclic_error", "stray_light", "unknown:gain", "amplitude_error", "lens_distortion"]


@dataclass(frozen=True)
class Spec:
    """Attributes:
    effects: names of those that are concealed.
    principle: "itof", "tri", or "" for a drawn one.
    null: what is special where nothing is missing, "" elsewhere.
    """

    effects: tuple[str, ...] = ()
    principle: str = ""
    null: str = ""

    @property
    def kind(self) -> str:
        return f"nothing: {self.null}" if self.null else ("one", "two")[len(self.effects) - 1]


def plan(seed: int, cases: int) -> list[Spec]:
    rng = np.random.default_rng([seed, 1])
    nulls, twos = round(0.3 * cases), round(0.17 * cases)
    specs = [Spec(null=NULLS[i % len(NULLS)]) for i in range(nulls)]
    flight, matching = ([str(name) for name in rng.permutation(list(names))] for names in (FLIGHT, MATCHING))
    i = j = 0
    for k in range(cases - nulls - twos):
        if k % 8 < 5:
            specs.append(Spec((flight[i % len(flight)],), "itof"))
            i += 1
        else:
            specs.append(Spec((matching[j % len(matching)],), "tri"))
            j += 1
    for k in range(twos):
        principle = "itof" if k % 3 else "tri"
        first, second = rng.choice(TOLD_APART[principle], 2, replace=False)
        specs.append(Spec((str(first), str(second)), principle))
    return [specs[i] for i in rng.permutation(cases)]


def easier(seed: int, case: int) -> Spec:
    """In place of an effect that could not be made visible."""
    return Spec((str(np.random.default_rng([seed, case]).choice(EASY)),), "itof")
