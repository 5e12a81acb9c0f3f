"""Camera file: depth that was right when the device made it, read with a camera that is not the device's.

Of a triangulating sensor `principal_point`, `focal_length` and `lens_distortion` say the same. A time-of-flight sensor
makes its depth from a range, with the camera that it knows itself: those effects are that camera being wrong, this is
the file.
"""

from dataclasses import asdict, dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.geometry.camera import Camera
from fusion.sensor.laws.moving import motions_found
from fusion.sensor.laws.surface import rigid_motions, towards

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

SMALL = 0.1  # of usual errors: linear


@dataclass(frozen=True)
class FileError:
    """Stated less true: centre [px], focal length and fy / fx over themselves, and distortion by OpenCV's names."""

    cx: float = 0.0
    cy: float = 0.0
    focal: float = 0.0
    aspect: float = 0.0
    k1: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    def taken_from(self, stated: Camera) -> Camera:
        """The device's camera."""
        long, tall = 1.0 + self.focal, float(np.sqrt(1.0 + self.aspect))
        k1, k2, p1, p2, *others = stated.distortion
        return replace(
            stated,
            fx=stated.fx / long * tall,
            fy=stated.fy / long / tall,
            cx=stated.cx - self.cx,
            cy=stated.cy - self.cy,
            distortion=(k1 - self.k1, k2, p1 - self.p1, p2 - self.p2, *others),
        )


# by which a file that nobody checked may be wrong (guesses): one of another unit, or of a calibration from few views.
USUAL = FileError(
    cx=3.0,  # [px] units of one kind differ by so much
    cy=3.0,
    focal=0.01,  # the same
    aspect=0.003,  # pixels are square, and a calibration from views of one tilt misses it
    k1=0.03,  # a file without it, or from boards that never were in the corners: 2 px 30 deg off the axis
    p1=0.001,  # lenses are centred to about that: a third of a pixel there
    p2=0.001,
)
NAMES = tuple(about.name for about in fields(FileError))
SIZES = np.array([getattr(USUAL, name) for name in NAMES])  # (k,)


def camera_columns(observations: Observations) -> Matrix:
    """(n, k) change in native units of a file that is wrong by `USUAL` in each of its numbers; (n, 0) of sensors that
    do not measure time of flight."""
    n = len(observations.residual)
    if not observations.patches[0].view.time_of_flight or any(
        patch.block.stage.caster is None for patch in observations.patches
    ):
        return np.zeros((n, 0))
    stated = observations.patches[0].view.camera
    off = [FileError(**{name: SMALL * asdict(USUAL)[name]}).taken_from(stated).rays() for name in NAMES]
    changes = (np.stack(off) - stated.rays()) / SMALL
    return np.concatenate([_seen_along(patch, changes) for patch in observations.patches])


def file_error(observations: Observations, pulled: Vector) -> FileError:
    """How wrong the camera file is, as the tiles tell it; nothing where they do not say that it is.

    Args:
        pulled: (n,) residual divided by its covariance.
    """
    size = observations.loose.camera
    if not size:
        return FileError()
    return FileError(*(SIZES * size**2 * (camera_columns(observations).T @ pulled)).tolist())


def _seen_along(patch: Patch, changes: NDArray[np.float32]) -> Matrix:
    """(n, k) what other rays make of a patch, to first order, for changes (k, h, w, 2) of rays."""
    view, depth = patch.view, patch.depth
    if view.normals is None:
        return np.zeros((len(patch.tiles), len(changes)))
    lever = depth * patch.native / towards(view)
    nx, ny = -lever * view.normals[..., 0], -lever * view.normals[..., 1]
    out = np.column_stack([patch.tiles.mean(nx * x + ny * y) for x, y in np.moveaxis(changes, -1, 1)])
    if view.placed_by_images:  # a pose that this camera's images gave is as wrong as the file
        moved = [patch.tiles.mean(change * patch.native) for change in rigid_motions(depth, view)]
        out += np.column_stack(moved) @ motions_found(changes, view)
    return out
