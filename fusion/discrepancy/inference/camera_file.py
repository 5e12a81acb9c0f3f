"""Camera file: depth that was right when the device made it, read with a camera that is not the device's.

Of a triangulating sensor `principal_point` and `focal_length` say the same. A time-of-flight sensor makes its depth
from a range, with the camera that it knows itself: those effects are that camera being wrong, this is the file.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations, Patch
from fusion.geometry.camera import Camera
from fusion.sensor.laws.moving import found_again
from fusion.sensor.laws.surface import seen_along

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

USUAL_PX = 3.0  # by which the centre of an image may be wrong in a file that nobody checked: guess
USUAL_SHARE = 0.01  # the same of its focal length: guess
SMALL = 0.01  # of these: linear


@dataclass(frozen=True)
class FileError:
    """Stated less true: centre [px], and focal length over itself."""

    cx: float = 0.0
    cy: float = 0.0
    focal: float = 0.0


def camera_columns(observations: Observations) -> Matrix:
    """(n, 3) change in native units of a file whose centre is off by `USUAL_PX` each way, and its focal length by
    `USUAL_SHARE`; (n, 0) of sensors that do not measure time of flight."""
    n = len(observations.residual)
    if not observations.patches[0].view.time_of_flight or any(
        patch.block.stage.caster is None for patch in observations.patches
    ):
        return np.zeros((n, 0))
    return np.concatenate([np.column_stack([_off(patch, k) for k in range(3)]) for patch in observations.patches])


def file_error(observations: Observations, pulled: Vector) -> FileError:
    """How wrong the camera file is, as the tiles tell it; nothing where they do not say that it is.

    Args:
        pulled: (n,) residual divided by its covariance.
    """
    size = observations.loose.camera
    if not size:
        return FileError()
    cx, cy, focal = (size**2 * (camera_columns(observations).T @ pulled)).tolist()
    return FileError(USUAL_PX * cx, USUAL_PX * cy, USUAL_SHARE * focal)


def _off(patch: Patch, which: int) -> Vector:
    """(n,) of a usual error of cx, cy or the focal length."""
    true, view = _true(patch.view.camera, which), patch.view
    # a pose that this camera's images gave is as wrong as the file
    motion = found_again(true, view) if view.placed_by_images else None
    seen = seen_along(patch.depth, true.rays(), view, motion)
    change = np.where(np.isfinite(seen), seen - patch.depth, 0.0) / SMALL
    return patch.tiles.mean(change * patch.native)


def _true(stated: Camera, which: int) -> Camera:
    if which < 2:
        name = ("cx", "cy")[which]
        return replace(stated, **{name: getattr(stated, name) - SMALL * USUAL_PX})
    share = 1.0 + SMALL * USUAL_SHARE
    return replace(stated, fx=stated.fx / share, fy=stated.fy / share)
