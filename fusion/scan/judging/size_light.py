"""How well the size is known."""

from typing import TYPE_CHECKING

from fusion.results.light import Light, level

if TYPE_CHECKING:
    from fusion.scan.result import Scan

# standard deviations from which twice as much is more than half a percent, and more than two percent
VAGUE = (0.0025, 0.01)
DO = (
    "Calibrate the depth again with walls a few centimetres apart about the object's distance and boards there "
    "(fusion calibrate depth --board), or measure one length of the object and scale by it."
)


def size_light(scan: "Scan") -> Light | None:
    """By what the calibration leaves open; None where no calibration of the depth says that."""
    if scan.sure is None or scan.motion.size_std is None:
        return None
    std = scan.sure.common.scale
    judged = level(std, VAGUE)
    said = f"The size is known to {100 * std:.2f} % (one standard deviation), as camera and depth are calibrated."
    if judged == "ok":
        return Light("ok", "Size", said)
    said += " Depth that is a little off over the object's range or over the image moves its axis, all round."
    return Light("warning", "Size", said, DO)
