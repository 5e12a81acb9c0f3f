"""The equations of all frames against the model that they make together, and their solution."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import robust_std
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.model.cells import normal_equations, settle
from fusion.turntable.model.meeting import AXIS, CELLS, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT, by_cell, meet
from fusion.turntable.model.rays import Bundle
from fusion.turntable.pairs.edge_pairs import ERRORS
from fusion.turntable.selfcheck import LENS, SelfCheck
from fusion.volume.sample import field
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
FOOT = 0.1  # share of the height that what it stands on is mixed into, by matching windows and wide pixels (guess)
SOME = 30_000  # equations that tell their scale, to 1 %


@dataclass(frozen=True)
class CellEquations:
    """The equations of all frames, m of them, sorted by their cell on the model."""

    # (m, 9 or more) as in `meeting`: residual [m], derivative in the frame's angle, sigma [m], by how much rough places
    # widen it, height [m], and derivatives in the axis (4, see `Axis.before_moved_camera`) and in errors of depth
    rows: NDArray[np.float32]
    # frame, ray: (m,) where each comes from
    frame: NDArray[np.int32]
    ray: NDArray[np.int32]
    first: NDArray[np.int32]  # (cells + 1,) where those of each cell begin
    n: int  # number of frames

    @property
    def shared(self) -> int:
        """How many unknowns all frames share."""
        return self.rows.shape[1] - SHARED


def equations(rays: Bundle, motion: Turns, volume: Volume, check: SelfCheck) -> CellEquations:
    """What each ray says where it meets the model, of the errors of depth too where `check` leaves them open."""
    axis, angles = motion
    poses = np.column_stack([placed(axis, angles)[:, :3].reshape(-1, 12), np.cos(angles), np.sin(angles)])
    columns = SHARED + AXIS + (ERRORS if check.open.any() else 0)
    cell, out = np.empty(len(rays.frame), np.int32), np.empty((len(rays.frame), columns), np.float32)
    reach = 0.75 * volume.settings.truncation
    meet(rays.frame, rays.values, poses.astype(np.float32), field(volume.blocks), reach, check.span, cell, out)
    counts = np.bincount(cell[cell >= 0], minlength=volume.block_count * CELLS)
    ends = np.cumsum(counts)
    order = np.empty(int(counts.sum()), np.int32)
    by_cell(cell, (ends - counts).astype(np.int32), order)
    first = np.append(0, ends[counts > 0]).astype(np.int32)
    return CellEquations(np.take(out, order, axis=0), rays.frame[order], order, first, rays.n)


def placed(axis: Axis, angles: Array) -> Array:
    """`T_object_camera` (n, 4, 4) of all frames, NaN where the angle is NaN."""
    back = np.array([pose.about_axis(np.zeros(3), np.array([0, 0, 1.0]), -a) for a in np.nan_to_num(angles)])
    poses = back @ axis.object_frame()
    poses[~np.isfinite(angles)] = np.nan
    return np.asarray(poses)


def steady_system(e: CellEquations) -> Array:
    """Normal matrix (s + n, s + n) of what tells where the axis is, without what is known of anything before."""
    lowest = _lowest(e)
    offset, scale = _settled(e, True, lowest)
    return normal_equations(e.rows, e.frame, e.first, offset, e.n, (scale, True, lowest))[0]


@dataclass(frozen=True)
class ModelSolution:
    """Steps and their standard deviations (s + n,): what is shared, angles; the cells' offsets [m]; scale of sigma."""

    step: Array
    std: Array
    offset: Array
    scale: float


def solve(e: CellEquations, check: SelfCheck, alike: float, steady: bool = False) -> ModelSolution:
    """One Gauss-Newton step; the cells' offsets are eliminated.

    Args:
        e: the equations.
        check: of the errors of depth.
        alike: by how much neighbouring pixels, which err alike, say less than they count.
        steady: only what tells where the axis is: not the object's foot, and of rough places as much as their windows
            tell.
    """
    lowest = _lowest(e) if steady else -np.inf
    offset, scale = _settled(e, steady, lowest)
    H, g = normal_equations(e.rows, e.frame, e.first, offset, e.n, (scale, steady, lowest))
    if e.shared > AXIS:
        errors = np.arange(AXIS, e.shared)
        information = alike**2 * check.information
        H[errors, errors] += information
        g[errors] += information * check.values[len(LENS) :]
    return ModelSolution(*_step(H, g), offset, scale)


def _lowest(e: CellEquations) -> float:
    """Height [m] from which the object is more than its foot."""
    low, high = np.percentile(e.rows[:: max(1, len(e.rows) // SOME), HEIGHT], [0.2, 99.8])
    return float(low + FOOT * (high - low))


def _settled(e: CellEquations, steady: bool, lowest: float) -> tuple[Array, float]:
    """Offsets of the cells [m], and the scale of sigma about them."""
    offset = np.zeros(len(e.first) - 1)
    for _ in range(2):
        settle(e.rows, e.first, offset, _scale(e, offset, steady, lowest), steady, lowest)
    return offset, _scale(e, offset, steady, lowest)


def _scale(e: CellEquations, offset: Array, steady: bool, lowest: float) -> float:
    """Observed over declared spread, from the median of some equations."""
    some = np.arange(0, len(e.rows), max(1, len(e.rows) // SOME))
    rest = e.rows[some, RESIDUAL] - offset[np.searchsorted(e.first, some, side="right") - 1]
    sigma = e.rows[some, SIGMA] * e.rows[some, SPOILT] if steady else e.rows[some, SIGMA]
    taken = (e.rows[some, HEIGHT] >= lowest) & np.isfinite(sigma)
    return max(robust_std(rest[taken] / sigma[taken]), 0.1) if taken.any() else 1.0


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
