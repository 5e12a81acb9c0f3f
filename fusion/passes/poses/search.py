"""The whole pose search: every rotation of an even set, and for each every shift, by correlation.

Both surfaces lie in a coarse grid. For a rotation, the sum over the second's points of the first's normals there times
their own, less a charge where the first pass looked through, is a correlation: one product in the Fourier domain gives
it for all shifts at once. No guess is needed, and no part of the surface has to be shared but the part that speaks.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage
from scipy.spatial.transform import Rotation

from fusion.geometry import pose
from fusion.passes.poses.sides import PassSide
from fusion.progress import each

Array = NDArray[np.float64]
ROTATIONS = 900  # the nearest is 20 degrees off at most, which blur and the steps after it bridge (guess)
CELLS = 18  # along the larger object's diagonal (guess)
CHARGE = 0.7  # of a point where the first pass looked through, against 1 for one that lies on its surface (guess)
SHIFTS = 2  # best shifts kept of each rotation
KEPT = 80  # candidates that go on
POINTS = 1500
PSI = 1.533751168755204288118041  # the positive root of x^4 = x + 4


def even_rotations(count: int) -> Array:
    """Rotation matrices (count, 3, 3) on a super-Fibonacci spiral (Alexa 2022, "Super-Fibonacci Spirals", algorithm 1).

    Of 900, the nearest to any rotation is 12 degrees off in the mean, and 21 at most (tests/passes).
    """
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1 - s / count)
    alpha, beta = 2 * np.pi * s / np.sqrt(2), 2 * np.pi * s / PSI
    quaternions = [inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta)]
    return np.asarray(Rotation.from_quat(np.stack(quaternions, axis=1)).as_matrix())


@dataclass(frozen=True)
class Grid:
    """Cells of a cube in the first's frame: the corner's centre [m], edge of a cell [m], cells along an edge."""

    corner: Array
    cell: float
    count: int

    def cells(self, points: Array) -> NDArray[np.intp]:
        """(n, 3) of points, not bounded."""
        return np.rint((points - self.corner) / self.cell).astype(np.intp)


def candidates(first: PassSide, second: PassSide) -> list[Array]:
    """Transforms (4, 4) from the second's frame to the first's, the most promising first."""
    cell = max(first.size, second.size) / CELLS
    low, high = first.points.min(axis=0), first.points.max(axis=0)
    count = fft.next_fast_len(int(np.ceil((np.max(high - low) + second.size) / cell)) + 4, real=True)
    grid = Grid((low + high) / 2 - cell * (count - 1) / 2, cell, count)
    field = fft.rfftn(_field(first, grid), axes=(1, 2, 3), workers=-1)
    found = []
    for R in each(even_rotations(ROTATIONS), "searching"):
        found += list(_shifts(field, second, R, grid))
    found.sort(key=lambda one: -one[0])
    return [T for _, T in found[:KEPT]]


def _field(side: PassSide, grid: Grid) -> NDArray[np.float32]:
    """(4, c, c, c): normals of the surface, blurred, and where the pass looked through."""
    out = np.zeros((4, *3 * [grid.count]), np.float32)
    at = tuple(grid.cells(side.points).T)
    for axis in range(3):
        np.add.at(out[axis], at, side.normals[:, axis].astype(np.float32))
    for axis in range(3):
        out[axis] = ndimage.gaussian_filter(out[axis], 0.8)
    length = np.linalg.norm(out[:3], axis=0)
    full = np.percentile(length[length > 0.01 * length.max()], 60)  # a cell that the surface crosses counts once
    out[:3] /= np.maximum(length, full)
    centres = grid.corner + grid.cell * np.stack(np.meshgrid(*3 * [np.arange(grid.count)], indexing="ij"), axis=-1)
    free = side.empty(centres.reshape(-1, 3)).reshape(3 * [grid.count])
    out[3] = -CHARGE * ndimage.binary_erosion(free)  # beside a surface a coarse cell holds both
    return out


def _shifts(field: NDArray[np.complex64], side: PassSide, R: Array, grid: Grid) -> Iterator[tuple[float, Array]]:
    """The best shifts of one rotation: score per point, transform."""
    step = max(1, len(side.points) // POINTS)
    points, normals = side.points[::step] @ R.T, side.normals[::step] @ R.T
    low = points.min(axis=0)
    at = tuple(np.rint((points - low) / grid.cell).astype(np.intp).T)
    own = np.zeros((4, *3 * [grid.count]), np.float32)
    for axis in range(3):
        np.add.at(own[axis], at, normals[:, axis].astype(np.float32))
    np.add.at(own[3], at, np.float32(1))
    product = np.einsum("kxyz,kxyz->xyz", field, np.conj(fft.rfftn(own, axes=(1, 2, 3), workers=-1)))
    score = fft.irfftn(product, s=3 * [grid.count], workers=-1) / len(points)
    for _ in range(SHIFTS):
        best = np.unravel_index(int(np.argmax(score)), score.shape)
        value = float(score[best])
        # a shift beyond half the cube is one to the other side
        cells = np.array(best, float)
        cells = np.where(cells > grid.count - 1 - 0.25 * grid.count, cells - grid.count, cells)
        yield value, pose.pose(R, grid.corner + cells * grid.cell - low)
        around = [np.arange(b - 2, b + 3) % grid.count for b in best]
        score[np.ix_(*around)] = -np.inf
