"""How well a scan can know its size, given how well camera and depth are known.

A constant error of depth moves the object and its axis alike and changes the size by its share of the distance only.
Errors that differ over the object's range of distance or over the image are another matter: the axis goes where it
suits all views best, and the surface stands that much nearer to it or farther from it all round. A stretch of 1 mm over
an object of 12 cm makes it 0.2 to 0.4 % too small or too large, though no depth is wrong by more than that.

Each error of depth (see `selfcheck`) is taken with its standard deviation before the scan was seen, and what the fit of
axis and angles makes of it is added up ("consider covariance", Schmidt 1966). What a scan finds of such errors is not
counted: they stand for all that may be wrong so, and what they do not hold is as large as what they do.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.axis import Turns
from fusion.turntable.model.meeting import AXIS
from fusion.turntable.model.rays import Bundle
from fusion.turntable.model.system import CellEquations, placed, steady_system
from fusion.turntable.selfcheck import SelfCheck

Array = NDArray[np.float64]
SOME = 30_000  # points that tell how the size changes
STEPS = np.full(AXIS, 1e-4)  # [rad], [m] small ones, for derivatives


def size_std(rays: Bundle, motion: Turns, e: CellEquations, check: SelfCheck) -> float:
    """Relative standard deviation of the size of what a motion makes of the rays.

    Args:
        rays: of all n frames, errors of depth taken out as for the motion.
        motion: axis, and angles (n,) [rad].
        e: the equations there, with derivatives in all errors of depth.
        check: its prior tells how wrong the depth may be.
    """
    if not check.open.any():
        return 0.0
    H = steady_system(e)
    said = np.r_[np.arange(AXIS), np.arange(e.shared, len(H))]  # axis and angles are fitted, the depth is as it is
    said = said[np.diag(H)[said] > 0]
    errors = np.arange(AXIS, e.shared)
    size = np.sqrt(np.diag(H)[said])
    inverse = np.linalg.pinv(H[np.ix_(said, said)] / np.outer(size, size), hermitian=True) / np.outer(size, size)
    response = -(inverse @ H[np.ix_(said, errors)])[: int(np.sum(said < AXIS))]
    growth = growths(rays, motion, check)
    by_error = growth[AXIS:] + growth[said[said < AXIS]] @ response
    return float(np.sqrt(np.sum(by_error**2 / check.information)))


def growths(rays: Bundle, motion: Turns, check: SelfCheck) -> Array:
    """By how much (4 + 10,) the size of the object grows, relative, per unit of each step of the axis and of each error
    of depth: the common scale, beside a rigid motion, of where the points go along their normals.
    """
    axis, angles = motion
    some = rays.thinned(SOME)
    poses = placed(axis, angles)[some.frame]
    points, normals = some.values[:, :3].astype(float), some.values[:, 3:6].astype(float)
    use = np.isfinite(poses).all(axis=(1, 2)) & np.isfinite(normals).all(axis=1)
    poses, points, normals, frame = poses[use], points[use], normals[use], some.frame[use]

    def at(T: Array) -> Array:
        return np.asarray(np.einsum("nij,nj->ni", T[:, :3, :3], points) + T[:, :3, 3])

    here, facing = at(poses), np.einsum("nij,nj->ni", poses[:, :3, :3], normals)
    moved = [placed(axis.before_moved_camera(step), angles)[frame] for step in np.diag(STEPS)]
    by_axis = [np.sum((at(T) - here) * facing, axis=1) / h for T, h in zip(moved, STEPS, strict=True)]
    by_depth = check.depth_terms(points) * (np.sum(points * normals, axis=1) / points[:, 2])[:, None]
    arm = here - here.mean(axis=0)
    rigid = np.column_stack([np.cross(arm, facing), facing, np.sum(arm * facing, axis=1)])
    shifts = np.column_stack([*by_axis, by_depth])
    return np.asarray(np.linalg.lstsq(rigid, shifts, rcond=None)[0][-1])
