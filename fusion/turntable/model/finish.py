"""The finish of the joint fit: every frame against the model that all frames make together.

The model is a volume filled with the motion so far. Each pixel's ray is followed to the model's surface; what the
pixel measured minus what the model says there is one equation in the frame's angle and the axis. Everything that
multiplies an unknown is taken where the ray meets the model, so it holds none of the pixel's own noise (pairs of
frames do: noise in both factors of a product pulls angles to zero and the axis to the camera). Errors of depth that
stand still in the image pull angles and axis too; they are unknowns beside these where a calibration leaves them open,
with its own uncertainty as their prior. The surface itself is unknown too: each small cell of it has an offset along
its normal, which is eliminated cell by cell, so that the model moves with the frames and the loop closes in one
solution instead of creeping.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import tukey
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.model.cells import CUT
from fusion.turntable.model.meeting import ANGLE, AXIS, RESIDUAL, SIGMA
from fusion.turntable.model.rays import Bundle, Rays, bundle
from fusion.turntable.model.system import CellEquations, ModelSolution, equations, placed, solve, steady_system
from fusion.turntable.selfcheck import SelfCheck
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
EARLY_FRAMES, EARLY_RAYS = 60, 500_000  # that make and meet the models before the last one
SOME = 30_000  # points that tell how the size changes
STEPS = np.full(AXIS, 1e-4)  # [rad], [m] small ones, for derivatives: far above rounding, far below a pixel


def size_std(rays: Bundle, motion: Turns, e: CellEquations, check: SelfCheck) -> float:
    """Relative standard deviation of the size of what a motion makes of the rays.

    A constant error of depth moves the object and its axis alike. Errors that differ over the object's range of
    distance or over the image do not: the axis goes where it suits all views best, and the surface stands nearer to it
    or farther all round. A stretch of 1 mm over an object of 12 cm changes it by 0.2 to 0.4 %, though no depth is wrong
    by more. Each error of depth (see `selfcheck`) is taken with its standard deviation before the scan was seen, and
    what the fit makes of it is added up ("consider covariance", Schmidt 1966); what the scan finds of such errors is
    not counted.

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


@dataclass(frozen=True)
class Finished:
    """Axis, angles (n,) [rad], 0 at the first, their standard deviations (n,) [rad] against the model, the errors of
    depth that are taken out beside those that the rays have lost already, and the axis' standard deviations (4,):
    tilts [rad] and shifts [m] of the camera along x and y of the object's frame; None where nothing was fitted. The
    same of the size, relative, by all errors of depth that a calibration may have; None where nothing says how large.
    `model`: the last one, and the turns that it was made with.
    """

    axis: Axis
    angles: Array
    angle_std: Array
    check: SelfCheck
    axis_std: Array | None = None
    size_std: float | None = None
    model: tuple[Volume, Turns] | None = None


@dataclass(frozen=True)
class How:
    """How a motion is finished."""

    rounds: int = 3  # how often the model is made anew
    held: bool = False  # the angles stay, where something tells them better than shape does
    # (13,) standard deviations of the errors of camera and depth before the scan was seen, by which the size is judged;
    # None where no calibration tells them
    doubt: Array | None = None


def finish(
    rays: Sequence[Rays | None],
    motion: Turns,
    build: Callable[[Axis, Array, SelfCheck], Volume],
    check: SelfCheck,
    how: How | None = None,
) -> Finished:
    """Refine axis and angles, and errors of depth, against the model.

    Args:
        rays: (n) per frame; None for a frame that takes no part.
        motion: axis, its point at the plate's height where there is a plate, and angles (n,) [rad]; NaN stays out.
        build: fills a volume in the object's frame (see `Axis.object_frame`) with a motion, errors of depth taken out.
        check: errors of depth to begin with; those with a prior above 0 are refined.
        how: what is done.
    """
    axis, angles = motion
    how = how or How()
    rounds = how.rounds
    every, alike = bundle(rays), 1.0
    for k in range(rounds):
        last = k == rounds - 1  # the others only have to come near: some frames make their model, some rays meet it
        turns = Turns(axis, angles)
        volume = build(axis, angles if last else _some_of(angles), check)
        seen = every if last else every.thinned(EARLY_RAYS)
        for _ in range(2):
            e = equations(seen.without(check), Turns(axis, angles), volume, check)
            if len(e.rows) == 0:  # nothing of what was seen lies near the model
                return Finished(axis, angles, np.full(len(angles), np.nan), check)
            firm = solve(e, check, alike, steady=True)
            steady = firm.step
            # the angles need all relief there is; what it gets wrong goes into shared unknowns of their own, dropped
            found = solve(e, check, alike)
            alike = _alike(e, seen.tiles, found)
            axis = axis.before_moved_camera(steady[:AXIS])
            check = check.moved(steady[AXIS : e.shared])
            if not how.held:
                angles = angles + found.step[e.shared :]
                angles = angles - angles[np.isfinite(angles)][0]
    std, size = found.std[e.shared :] * alike, None
    if how.doubt is not None:
        open_, left = replace(check, prior=how.doubt), seen.without(check)
        size = size_std(left, Turns(axis, angles), equations(left, Turns(axis, angles), volume, open_), open_)
    known = np.isfinite(angles)
    return Finished(axis, angles, np.where(known, std, np.nan), check, firm.std[:AXIS] * alike, size, (volume, turns))


def _some_of(angles: Array) -> Array:
    """Angles (n,) of about EARLY_FRAMES frames; the others NaN."""
    known = np.flatnonzero(np.isfinite(angles))
    chosen = known[:: max(1, len(known) // EARLY_FRAMES)]
    return np.where(np.isin(np.arange(len(angles)), chosen), angles, np.nan)


def _alike(e: CellEquations, tiles: NDArray[np.int32], found: ModelSolution) -> float:
    """By how much errors that neighbouring pixels share widen the standard deviations (clustered by tiles)."""
    rest = e.rows[:, RESIDUAL] - np.repeat(found.offset, np.diff(e.first))
    sigma = e.rows[:, SIGMA].astype(float)
    share = rest * e.rows[:, ANGLE] * tukey(rest / (found.scale * sigma), CUT) / sigma**2
    tile = np.ravel_multi_index((e.frame, *tiles[e.ray].T), (e.n, *(tiles.max(axis=0) + 1)))
    return max(1.0, float(np.sqrt(np.sum(np.bincount(tile, share) ** 2) / np.maximum(np.sum(share**2), 1e-300))))
