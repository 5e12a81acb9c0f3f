"""The finish of the joint fit: every frame against the model that all frames make together.

The model is a volume filled with the motion so far. Each pixel's ray is followed to the model's surface; what the
pixel measured minus what the model says there is one equation in the frame's angle and the axis. Everything that
multiplies an unknown is taken where the ray meets the model, so it holds none of the pixel's own noise (pairs of
frames do: noise in both factors of a product pulls angles to zero and the axis to the camera). The surface itself is
unknown too: each small cell of it has an offset along its normal, which is eliminated cell by cell, so that the model
moves with the frames and the loop closes in one solution instead of creeping.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.tracking.pairs import tukey
from fusion.turntable.axis import Axis
from fusion.turntable.model.cells import CUT, SHARED, normal_equations, settle
from fusion.turntable.model.meeting import CELLS, COLUMNS, by_cell, meet
from fusion.turntable.model.rays import Bundle, Rays, bundle
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
FOOT = 0.1  # share of the height that what it stands on is mixed into, by matching windows and wide pixels (guess)
EARLY_FRAMES, EARLY_RAYS = 60, 500_000  # that make and meet the models before the last one
SOME = 30_000  # equations that tell their scale, to 1 %


@dataclass(frozen=True)
class Finished:
    """Axis, angles (n,) [rad], 0 at the first, and their standard deviations (n,) [rad] against the model."""

    axis: Axis
    angles: Array
    angle_std: Array


@dataclass(frozen=True)
class Equations:
    """The equations of all frames, m of them, sorted by their cell on the model.

    Attributes:
        rows: (m, 9) residual [m], derivatives in the frame's angle and in the axis (4, see `_moved`), sigma [m],
            by how much rough places widen it, height [m].
        frame, ray: (m,) where each comes from.
        first: (cells + 1,) where those of each cell begin.
        n: number of frames.
    """

    rows: NDArray[np.float32]
    frame: NDArray[np.int32]
    ray: NDArray[np.int32]
    first: NDArray[np.int32]
    n: int


def finish(
    rays: Sequence[Rays | None],
    motion: tuple[Axis, Array],
    build: Callable[[Axis, Array], Volume],
    rounds: int = 3,
    held: bool = False,
) -> Finished:
    """Refine axis and angles against the model.

    Args:
        rays: (n) per frame; None for a frame that takes no part.
        motion: axis, its point at the plate's height where there is a plate, and angles (n,) [rad]; NaN stays out.
        build: fills a volume in the object's frame (see `Axis.object_frame`) with a motion.
        rounds: how often the model is made anew.
        held: the angles stay, where something tells them better than shape does.
    """
    axis, angles = motion
    every = bundle(rays)
    for k in range(rounds):
        last = k == rounds - 1  # the others only have to come near: some frames make their model, some rays meet it
        volume, seen = build(axis, angles if last else _some_of(angles)), every if last else every.thinned(EARLY_RAYS)
        for _ in range(2):
            e = equations(seen, (axis, angles), volume)
            if len(e.rows) == 0:  # nothing of what was seen lies near the model
                return Finished(axis, angles, np.full(len(angles), np.nan))
            shared = _solve(e, steady=True).step[:SHARED]
            # the angles need all relief there is; what it gets wrong goes into an axis of their own, which is dropped
            found = _solve(e)
            axis = _moved(axis, shared)
            if not held:
                angles = angles + found.step[SHARED:]
                angles = angles - angles[np.isfinite(angles)][0]
    std = found.std[SHARED:] * _alike(e, every.tiles, found)
    return Finished(axis, angles, np.where(np.isfinite(angles), std, np.nan))


def _some_of(angles: Array) -> Array:
    """Angles (n,) of about EARLY_FRAMES frames; the others NaN."""
    known = np.flatnonzero(np.isfinite(angles))
    chosen = known[:: max(1, len(known) // EARLY_FRAMES)]
    return np.where(np.isin(np.arange(len(angles)), chosen), angles, np.nan)


def equations(rays: Bundle, motion: tuple[Axis, Array], volume: Volume) -> Equations:
    """What each ray says where it meets the model."""
    axis, angles = motion
    back = np.array([pose.about_axis(np.zeros(3), np.array([0, 0, 1.0]), -a) for a in np.nan_to_num(angles)])
    poses = np.column_stack([(back @ axis.object_frame())[:, :3].reshape(-1, 12), np.cos(angles), np.sin(angles)])
    poses[~np.isfinite(angles)] = np.nan
    cell, out = np.empty(len(rays.frame), np.int32), np.empty((len(rays.frame), COLUMNS), np.float32)
    blocks, reach = volume.blocks, 0.75 * volume.settings.truncation
    meet(
        rays.frame, rays.values, poses.astype(np.float32), blocks.keys, blocks.ids, blocks.neighbours, blocks.flat,
        volume.settings.voxel, reach, cell, out,
    )  # fmt: skip
    counts = np.bincount(cell[cell >= 0], minlength=volume.block_count * CELLS)
    ends = np.cumsum(counts)
    order = np.empty(int(counts.sum()), np.int32)
    by_cell(cell, (ends - counts).astype(np.int32), order)
    first = np.append(0, ends[counts > 0]).astype(np.int32)
    return Equations(np.take(out, order, axis=0), rays.frame[order], order, first, rays.n)


@dataclass(frozen=True)
class _Solution:
    """Steps and their standard deviations (4 + n,): axis, angles; the cells' offsets [m], and the scale of sigma."""

    step: Array
    std: Array
    offset: Array
    scale: float


def _solve(e: Equations, steady: bool = False) -> _Solution:
    """One Gauss-Newton step; the cells' offsets are eliminated.

    Args:
        e: the equations.
        steady: only what tells where the axis is: not the object's foot, and of rough places as much as their windows
            tell.
    """
    low, high = np.percentile(e.rows[:: max(1, len(e.rows) // SOME), 8], [0.2, 99.8])
    lowest = float(low + FOOT * (high - low)) if steady else -np.inf
    offset = np.zeros(len(e.first) - 1)
    for _ in range(2):
        settle(e.rows, e.first, offset, _scale(e, offset, steady, lowest), steady, lowest)
    scale = _scale(e, offset, steady, lowest)
    H, g = normal_equations(e.rows, e.frame, e.first, offset, e.n, (scale, steady, lowest))
    return _Solution(*_step(H, g), offset, scale)


def _scale(e: Equations, offset: Array, steady: bool, lowest: float) -> float:
    """Observed over declared spread, from the median of some equations."""
    some = np.arange(0, len(e.rows), max(1, len(e.rows) // SOME))
    rest = e.rows[some, 0] - offset[np.searchsorted(e.first, some, side="right") - 1]
    sigma = e.rows[some, 6] * e.rows[some, 7] if steady else e.rows[some, 6]
    taken = e.rows[some, 8] >= lowest
    return max(1.4826 * float(np.median(np.abs(rest[taken]) / sigma[taken])), 0.1) if taken.any() else 1.0


def _alike(e: Equations, tiles: NDArray[np.int32], found: _Solution) -> float:
    """By how much errors that neighbouring pixels share widen the standard deviations (clustered by tiles)."""
    rest = e.rows[:, 0] - np.repeat(found.offset, np.diff(e.first))
    share = rest * e.rows[:, 1] * tukey(rest / (found.scale * e.rows[:, 6]), CUT) / e.rows[:, 6].astype(float) ** 2
    tile = np.ravel_multi_index((e.frame, *tiles[e.ray].T), (e.n, *(tiles.max(axis=0) + 1)))
    return max(1.0, float(np.sqrt(np.sum(np.bincount(tile, share) ** 2) / np.maximum(np.sum(share**2), 1e-300))))


def _step(H: Array, g: Array) -> tuple[Array, Array]:
    """Step and standard deviation; what has no equations stays.

    No angle is held: where all frames turn together, the model stays where it is, and the step is a small one.
    """
    free = np.diag(H) > 0
    step, std = np.zeros((2, len(g)))
    size = np.sqrt(np.diag(H)[free])
    inverse = np.linalg.pinv(H[np.ix_(free, free)] / np.outer(size, size), hermitian=True) / np.outer(size, size)
    step[free] = -inverse @ g[free]
    std[free] = np.sqrt(np.maximum(np.diag(inverse), 0))
    return step, std


def _moved(axis: Axis, step: Array) -> Axis:
    """The axis after tilts [rad] and shifts [m] of the camera along x and y of the object's frame."""
    T = pose.inverse(pose.exp([step[0], step[1], 0, step[2], step[3], 0]) @ axis.object_frame())
    return Axis(T[:3, 3], T[:3, 2])
