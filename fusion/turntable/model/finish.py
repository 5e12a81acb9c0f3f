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

from fusion.tracking.pairs import tukey
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.model.cells import CUT
from fusion.turntable.model.meeting import ANGLE, AXIS, RESIDUAL, SIGMA
from fusion.turntable.model.rays import Rays, bundle
from fusion.turntable.model.size import size_std
from fusion.turntable.model.system import CellEquations, ModelSolution, equations, solve
from fusion.turntable.selfcheck import SelfCheck
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
EARLY_FRAMES, EARLY_RAYS = 60, 500_000  # that make and meet the models before the last one


@dataclass(frozen=True)
class Finished:
    """Axis, angles (n,) [rad], 0 at the first, their standard deviations (n,) [rad] against the model, the errors of
    depth that are taken out beside those that the rays have lost already, and the axis' standard deviations (4,):
    tilts [rad] and shifts [m] of the camera along x and y of the object's frame; None where nothing was fitted. The
    same of the size, relative, by all errors of depth that a calibration may have; None where nothing says how large.
    """

    axis: Axis
    angles: Array
    angle_std: Array
    check: SelfCheck
    axis_std: Array | None = None
    size_std: float | None = None


@dataclass(frozen=True)
class How:
    """How a motion is finished.

    Attributes:
        rounds: how often the model is made anew.
        held: the angles stay, where something tells them better than shape does.
        doubt: (13,) standard deviations of the errors of camera and depth before the scan was seen, by which the size
            is judged; None where no calibration tells them.
    """

    rounds: int = 3
    held: bool = False
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
    return Finished(axis, angles, np.where(known, std, np.nan), check, firm.std[:AXIS] * alike, size)


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
