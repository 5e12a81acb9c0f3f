"""The words of a setting: poses, camera file, mesh and targets that are worse than stated."""

from math import log

from fusion.discrepancy.decisions import SURE
from fusion.discrepancy.inference.camera_file import FileError
from fusion.discrepancy.verdict.content import Nuisances

WORSE = 1.5  # times the stated errors of poses, from which on a person wants to hear of it
SIZED = 1e-3  # of a mesh: what is less is told as a place and not as a size


def misplaced(nuisances: Nuisances) -> bool:
    """True where these are other poses: so much worse than stated (a factor of e is usual) that chance has it nowhere.

    A camera file that is wrong may make up for it.
    """
    return log(nuisances.pose_factor) ** 2 >= SURE and not _wrong(nuisances.camera_file)


def setting_words(nuisances: Nuisances) -> str:
    """How much worse than stated poses and targets are, as the end of a clause; empty where they are as stated."""
    said, wrong = [], _wrong(nuisances.camera_file)
    if nuisances.pose_factor >= WORSE:
        times = f"{nuisances.pose_factor:.2g} times"
        said.append(f"poses are about {times} worse than stated" + ("" if wrong else ", or the camera file is wrong"))
    if wrong:
        said.append(f"the camera file seems wrong: {wrong}")
    if nuisances.mesh_off_m > 0:
        scale = nuisances.mesh_scale
        size = f"{100 * abs(scale):.2g} % too {'small' if scale > 0 else 'large'}"
        how = size if abs(scale) > SIZED else "elsewhere than stated"
        said.append(f"the mesh is {how}: surfaces are off by about {mm(nuisances.mesh_off_m)}")
    if nuisances.shape_rms_m > 0:
        said.append(f"targets leave their mesh by about {mm(nuisances.shape_rms_m)}, though no tolerance is stated")
    return "".join(f", {one}" for one in said)


def _wrong(off: FileError) -> str:
    """What is wrong in a camera file, in px, shares and coefficients; nothing of what is none of their last digit.

    That of a coefficient moves the rim of a usual image by about half a pixel.
    """
    px = {"cx": off.cx, "cy": off.cy}
    shares = {"focal length": off.focal, "fy / fx": off.aspect}
    told = [f"{name} by {value:+.1f} px" for name, value in px.items() if round(value, 1)]
    told += [f"{name} by {100 * value:+.1f} %" for name, value in shares.items() if round(value, 3)]
    bends = (("k1", off.k1, 2), ("p1", off.p1, 3), ("p2", off.p2, 3))
    told += [f"{name} by {value:+.{digits}f}" for name, value, digits in bends if round(value, digits)]
    return ", ".join(told)


def mm(metres: float) -> str:
    """A length with its unit."""
    return f"{1e3 * metres:.2g} mm" if metres < 0.0995 else f"{1e3 * metres:.0f} mm"
