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
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.tracking.pairs import tukey
from fusion.turntable.axis import Axis
from fusion.turntable.model.cells import CUT, normal_equations, settle
from fusion.turntable.model.meeting import ANGLE, AXIS, CELLS, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT, by_cell, meet
from fusion.turntable.model.rays import Bundle, Rays, bundle
from fusion.turntable.pairs.edge_pairs import ERRORS
from fusion.turntable.selfcheck import LENS, SelfCheck
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
FOOT = 0.1  # share of the height that what it stands on is mixed into, by matching windows and wide pixels (guess)
EARLY_FRAMES, EARLY_RAYS = 60, 500_000  # that make and meet the models before the last one
SOME = 30_000  # equations that tell their scale, to 1 %


@dataclass(frozen=True)
class Finished:
    """Axis, angles (n,) [rad], 0 at the first, their standard deviations (n,) [rad] against the model, the errors of
    depth that are taken out beside those that the rays have lost already, and the axis' standard deviations (4,):
    tilts [rad] and shifts [m] of the camera along x and y of the object's frame; None where nothing was fitted.
    """

    axis: Axis
    angles: Array
    angle_std: Array
    check: SelfCheck
    axis_std: Array | None = None


@dataclass(frozen=True)
class Equations:
    """The equations of all frames, m of them, sorted by their cell on the model.

    Attributes:
        rows: (m, 9 or more) as in `meeting`: residual [m], derivative in the frame's angle, sigma [m], by how much
            rough places widen it, height [m], and derivatives in the axis (4, see `_moved`) and in errors of depth.
        frame, ray: (m,) where each comes from.
        first: (cells + 1,) where those of each cell begin.
        n: number of frames.
    """

    rows: NDArray[np.float32]
    frame: NDArray[np.int32]
    ray: NDArray[np.int32]
    first: NDArray[np.int32]
    n: int

    @property
    def shared(self) -> int:
        """How many unknowns all frames share."""
        return self.rows.shape[1] - SHARED


def finish(
    rays: Sequence[Rays | None],
    motion: tuple[Axis, Array],
    build: Callable[[Axis, Array, SelfCheck], Volume],
    check: SelfCheck,
    rounds: int = 3,
    held: bool = False,
) -> Finished:
    """Refine axis and angles, and errors of depth, against the model.

    Args:
        rays: (n) per frame; None for a frame that takes no part.
        motion: axis, its point at the plate's height where there is a plate, and angles (n,) [rad]; NaN stays out.
        build: fills a volume in the object's frame (see `Axis.object_frame`) with a motion, errors of depth taken out.
        check: errors of depth to begin with; those with a prior above 0 are refined.
        rounds: how often the model is made anew.
        held: the angles stay, where something tells them better than shape does.
    """
    axis, angles = motion
    every, alike = bundle(rays), 1.0
    for k in range(rounds):
        last = k == rounds - 1  # the others only have to come near: some frames make their model, some rays meet it
        volume = build(axis, angles if last else _some_of(angles), check)
        seen = every if last else every.thinned(EARLY_RAYS)
        for _ in range(2):
            e = equations(seen.without(check), (axis, angles), volume, check)
            if len(e.rows) == 0:  # nothing of what was seen lies near the model
                return Finished(axis, angles, np.full(len(angles), np.nan), check)
            firm = _solve(e, (check, alike), steady=True)
            steady = firm.step
            # the angles need all relief there is; what it gets wrong goes into shared unknowns of their own, dropped
            found = _solve(e, (check, alike))
            alike = _alike(e, seen.tiles, found)
            axis = _moved(axis, steady[:AXIS])
            check = check.moved(steady[AXIS : e.shared])
            if not held:
                angles = angles + found.step[e.shared :]
                angles = angles - angles[np.isfinite(angles)][0]
    std = found.std[e.shared :] * alike
    return Finished(axis, angles, np.where(np.isfinite(angles), std, np.nan), check, firm.std[:AXIS] * alike)


def _some_of(angles: Array) -> Array:
    """Angles (n,) of about EARLY_FRAMES frames; the others NaN."""
    known = np.flatnonzero(np.isfinite(angles))
    chosen = known[:: max(1, len(known) // EARLY_FRAMES)]
    return np.where(np.isin(np.arange(len(angles)), chosen), angles, np.nan)


def equations(rays: Bundle, motion: tuple[Axis, Array], volume: Volume, check: SelfCheck) -> Equations:
    """What each ray says where it meets the model, of the errors of depth too where `check` leaves them open."""
    axis, angles = motion
    back = np.array([pose.about_axis(np.zeros(3), np.array([0, 0, 1.0]), -a) for a in np.nan_to_num(angles)])
    poses = np.column_stack([(back @ axis.object_frame())[:, :3].reshape(-1, 12), np.cos(angles), np.sin(angles)])
    poses[~np.isfinite(angles)] = np.nan
    columns = SHARED + AXIS + (ERRORS if check.open.any() else 0)
    cell, out = np.empty(len(rays.frame), np.int32), np.empty((len(rays.frame), columns), np.float32)
    blocks, reach = volume.blocks, 0.75 * volume.settings.truncation
    meet(
        rays.frame, rays.values, poses.astype(np.float32), blocks.keys, blocks.ids, blocks.neighbours, blocks.flat,
        volume.settings.voxel, reach, check.span, cell, out,
    )  # fmt: skip
    counts = np.bincount(cell[cell >= 0], minlength=volume.block_count * CELLS)
    ends = np.cumsum(counts)
    order = np.empty(int(counts.sum()), np.int32)
    by_cell(cell, (ends - counts).astype(np.int32), order)
    first = np.append(0, ends[counts > 0]).astype(np.int32)
    return Equations(np.take(out, order, axis=0), rays.frame[order], order, first, rays.n)


@dataclass(frozen=True)
class _Solution:
    """Steps and their standard deviations (s + n,): what is shared, angles; the cells' offsets [m]; scale of sigma."""

    step: Array
    std: Array
    offset: Array
    scale: float


def _solve(e: Equations, known: tuple[SelfCheck, float], steady: bool = False) -> _Solution:
    """One Gauss-Newton step; the cells' offsets are eliminated.

    Args:
        e: the equations.
        known: of the errors of depth, and by how much neighbouring pixels, which err alike, say less than they count.
        steady: only what tells where the axis is: not the object's foot, and of rough places as much as their windows
            tell.
    """
    low, high = np.percentile(e.rows[:: max(1, len(e.rows) // SOME), HEIGHT], [0.2, 99.8])
    lowest = float(low + FOOT * (high - low)) if steady else -np.inf
    offset = np.zeros(len(e.first) - 1)
    for _ in range(2):
        settle(e.rows, e.first, offset, _scale(e, offset, steady, lowest), steady, lowest)
    scale = _scale(e, offset, steady, lowest)
    H, g = normal_equations(e.rows, e.frame, e.first, offset, e.n, (scale, steady, lowest))
    if e.shared > AXIS:
        (check, alike), errors = known, np.arange(AXIS, e.shared)
        information = alike**2 * check.information
        H[errors, errors] += information
        g[errors] += information * check.values[len(LENS) :]
    return _Solution(*_step(H, g), offset, scale)


def _scale(e: Equations, offset: Array, steady: bool, lowest: float) -> float:
    """Observed over declared spread, from the median of some equations."""
    some = np.arange(0, len(e.rows), max(1, len(e.rows) // SOME))
    rest = e.rows[some, RESIDUAL] - offset[np.searchsorted(e.first, some, side="right") - 1]
    sigma = e.rows[some, SIGMA] * e.rows[some, SPOILT] if steady else e.rows[some, SIGMA]
    taken = e.rows[some, HEIGHT] >= lowest
    return max(1.4826 * float(np.median(np.abs(rest[taken]) / sigma[taken])), 0.1) if taken.any() else 1.0


def _alike(e: Equations, tiles: NDArray[np.int32], found: _Solution) -> float:
    """By how much errors that neighbouring pixels share widen the standard deviations (clustered by tiles)."""
    rest = e.rows[:, RESIDUAL] - np.repeat(found.offset, np.diff(e.first))
    sigma = e.rows[:, SIGMA].astype(float)
    share = rest * e.rows[:, ANGLE] * tukey(rest / (found.scale * sigma), CUT) / sigma**2
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
