"""The focal length: what was stated, what the scan says of it, and what was done; how well the size is known."""

from typing import TYPE_CHECKING

from fusion.geometry.robust import DOUBT, SURE
from fusion.results.light import Light, level

if TYPE_CHECKING:
    from fusion.scan.result import Scan

VAGUE = 0.02  # relative standard deviation from which a scan says too little of a camera that is only nominal (guess)
CALIBRATE = "Calibrate the camera (fusion calibrate intrinsics)"
# standard deviations from which twice as much is more than half a percent, and more than two percent
SIZE = (0.0025, 0.01)
NEARER = "Scan from nearer, or measure one length of the object and scale by it."
WALLS = (
    "Calibrate the depth again with walls a few centimetres apart about the object's distance and boards there "
    "(fusion calibrate depth --board), or measure one length of the object and scale by it."
)


def camera_light(scan: "Scan") -> Light:
    """One light: corrected, contradicted, in doubt, not to be checked, or good."""
    focal, stated = scan.evidence.focal, scan.evidence.stated_camera
    right = stated.fx * (1 + focal.relative)
    off = focal.deviations(stated)
    if scan.evidence.refined:
        said = f"The focal length is corrected: fx {scan.camera.fx:.1f} instead of {stated.fx:.1f} px ({focal.said()})"
        asked = scan.settings.refine_camera is True
        why = ", as asked for" if asked else ", by the scan itself, as the camera is only nominal"
        do = f"{CALIBRATE} to be sure; --keep-camera leaves it as stated."
        return Light("warning", "Camera", f"{said}{why}{_or_depth(scan, focal.relative)}.", do)
    said = f"The object keeps its shape only with fx {right:.1f} instead of {stated.fx:.1f} px ({focal.said()})"
    if off > SURE:
        so = f"so its size is wrong by about {abs(focal.relative):.0%}"
        do = f"{CALIBRATE}{' again' if stated.std else ''}, or take the scan's correction with --refine-camera."
        if "fx" in stated.std and scan.settings.correction.undone_m:
            said += ", or with another depth law: one that is wrong over distance bends it just so"
            do = f"{CALIBRATE} again, and the depth with more walls near the object (fusion calibrate depth)."
        return Light("bad", "Camera", f"{said}: {so}.", do)
    if off > DOUBT:
        return Light("warning", "Camera", f"{said}, perhaps.", f"{CALIBRATE}, or record another turn.")
    if focal.told > VAGUE and "fx" in stated.std:
        said = f"The focal length is taken from the calibration; the scan tells it to {focal.told:.0%} only"
        return Light("ok", "Camera", f"{said}.")
    if focal.told > VAGUE:
        said = f"The focal length is only nominal, and the scan tells it to {focal.told:.0%} only"
        return Light("warning", "Camera", f"{said}: so well is the size known.", f"{CALIBRATE}.")
    return Light("ok", "Camera", f"The focal length keeps the turning object in shape ({focal.said()}).")


def _or_depth(scan: "Scan", relative: float) -> str:
    """Errors of depth that bend the object just so; empty where a calibration says how wrong the depth is."""
    if scan.motion.size_std is not None:
        return ""
    off, much = abs(relative) * float(scan.motion.axis.point[2]) * 1e3, f"{abs(relative):.1%}"
    where, how = ("far", "little") if relative > 0 else ("near", "much")
    return f"; a depth that reads {off:.0f} mm too {where}, or changes by {much} too {how}, would ask for the same"


def size_light(scan: "Scan") -> list[Light]:
    """By what the calibration leaves open; nothing where no calibration of the depth says that."""
    if scan.sure is None or scan.motion.size_std is None:
        return []
    common = scan.sure.common
    judged = level(common.whole, SIZE)
    said = (
        f"The size is known to {100 * common.whole:.2f} % (one standard deviation), as camera and depth are calibrated"
    )
    said += f"; what windows and pixels flatten is {100 * common.blur:.2f} % of it." if common.blur > 0 else "."
    if judged == "ok":
        return [Light("ok", "Size", said)]
    if common.blur > common.scale:
        return [Light("warning", "Size", said, NEARER)]
    said += " Depth that is a little off over the object's range or over the image moves its axis, all round."
    return [Light("warning", "Size", said, WALLS)]
