"""The finish of the joint fit: every frame against the model that all frames make together.

The model is a volume filled with the motion so far. Each pixel's ray is followed to the model's surface; what the
pixel measured minus what the model says there is one equation in the frame's angle and the axis. Everything that
multiplies an unknown is taken where the ray meets the model, so it holds none of the pixel's own noise (pairs of
frames do: noise in both factors of a product pulls angles to zero and the axis to the camera). The surface itself is
unknown too: each small cell of it has an offset along its normal, which is eliminated cell by cell, so that the model
moves with the frames and the loop closes in one solution instead of creeping.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fusion.geometry import pose
from fusion.geometry.depth import PointMap
from fusion.tracking.pairs import tukey
from fusion.turntable.axis import Axis
from fusion.turntable.rough import HALF, shared_errors
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
CUT = 3.5  # robust standard deviations at which a pixel stops to count
TILE = 16  # [px] farther apart than this, errors are taken as independent (guess)
CELLS = 2.0  # [voxels] edge of a cell with one offset
LEAST_COSINE = 0.2  # of ray and model normal
PLATE_LEVEL, PLATE_NEAR = 0.9, 0.03  # cosine to the axis, and height [m], of what may be the plate
FOOT = 0.1  # share of the height that what it stands on is mixed into, by matching windows and wide pixels (guess)
SHARED = 4


@dataclass(frozen=True)
class Rays:
    """What one frame shows of the object.

    Attributes:
        points, normals: (n, 3) in the camera [m].
        sigma: (n,) standard deviation of the depth [m].
        spoilt: (n,) by how much the errors of rough places (see `shared_errors`) widen it.
        pixels: (n, 2) row and column, counted on the grid that was kept.
    """

    points: Array
    normals: Array
    sigma: Array
    spoilt: Array
    pixels: NDArray[np.int64]


def rays_of(surface: PointMap, usable: NDArray[np.bool_], most: int = 20_000) -> Rays:
    """The usable pixels (h, w) of a surface, on a coarser grid where they are more than `most`."""
    stride = max(1, int(np.ceil(np.sqrt(usable.sum() / most))))
    grid = np.zeros_like(usable)
    grid[::stride, ::stride] = usable[::stride, ::stride]
    grid &= np.isfinite(surface.sigma)
    pixels = np.argwhere(grid)
    # n pixels with a common error tell as little as one with it: n of them weigh 1 / (noise + n * common) each
    together = ((2 * HALF + 1) / stride) ** 2
    common = shared_errors(surface.points[..., 2], surface.sigma, usable & np.isfinite(surface.sigma))[grid]
    return Rays(
        surface.points[grid].astype(float), surface.normals[grid].astype(float),
        surface.sigma[grid].astype(float), np.sqrt(1 + together * common), pixels // stride,
    )  # fmt: skip


@dataclass(frozen=True)
class Finished:
    """Axis, angles (n,) [rad], 0 at the first, and their standard deviations (n,) [rad] against the model."""

    axis: Axis
    angles: Array
    angle_std: Array


@dataclass(frozen=True)
class _Equations:
    """The equations of all frames, m of them: frame, place on the model, residual, derivatives, sigma, pixel."""

    frame: NDArray[np.int64]  # (m,)
    place: Array  # (m, 3) in the object's frame
    residual: Array  # (m,) along the model's normal [m]
    angle: Array  # (m,) derivative in the frame's angle
    shared: Array  # (m, 4) in the axis (see `_moved`)
    sigma: Array  # (m,)
    spoilt: Array  # (m,)
    pixels: NDArray[np.int64]  # (m, 2)


def finish(
    rays: Sequence[Rays | None],
    motion: tuple[Axis, Array],
    build: Callable[[Axis, Array], Volume],
    rounds: int = 3,
) -> Finished:
    """Refine axis and angles against the model.

    Args:
        rays: (n) per frame; None for a frame that takes no part.
        motion: axis, its point at the plate's height where there is a plate, and angles (n,) [rad]; NaN stays out.
        build: fills a volume in the object's frame (see `Axis.object_frame`) with a motion.
        rounds: how often the model is made anew.
    """
    axis, angles = motion
    std = np.full(len(angles), np.nan)
    for _ in range(rounds):
        volume = build(axis, angles)
        cell = CELLS * volume.settings.voxel
        for _ in range(2):
            e = _equations(rays, (axis, angles), volume)
            shared = _solve(_steady(e), cell, len(angles)).step[:SHARED]
            # the angles need all relief there is; what it gets wrong goes into an axis of their own, which is dropped
            found = _solve(e, cell, len(angles))
            axis, angles = _moved(axis, shared), angles + found.step[SHARED:]
            angles = angles - angles[np.isfinite(angles)][0]
            std = np.where(np.isfinite(angles), found.std[SHARED:], np.nan)
    return Finished(axis, angles, std)


def _equations(
    rays: Sequence[Rays | None],
    motion: tuple[Axis, Array],
    volume: Volume,
) -> _Equations:
    axis, angles = motion
    T_object_camera = axis.object_frame()
    parts = []
    for i, (seen, angle) in enumerate(zip(rays, angles, strict=True)):
        if seen is not None and np.isfinite(angle):
            parts.append(_of_frame(i, seen, (T_object_camera, float(angle)), volume))
    return _Equations(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _steady(e: _Equations) -> _Equations:
    """What tells where the axis is: not the object's foot, and of rough places as much as their windows tell."""
    low, high = np.percentile(e.place[:, 2], [0.2, 99.8])
    return _chosen(replace(e, sigma=e.sigma * e.spoilt), e.place[:, 2] >= low + FOOT * (high - low))


def _chosen(e: _Equations, kept: NDArray[np.bool_]) -> _Equations:
    return replace(e, **{entry.name: getattr(e, entry.name)[kept] for entry in fields(e)})


def _of_frame(
    number: int,
    rays: Rays,
    place: tuple[Array, float],
    volume: Volume,
) -> tuple[NDArray, ...]:
    """The equations of one frame, in the order of `_Equations`."""
    T_object_camera, angle = place
    back = pose.about_axis(np.zeros(3), np.array([0, 0, 1.0]), -angle)
    T = back @ T_object_camera
    R = T[:3, :3]
    measured = pose.transform(T, rays.points)
    direction = rays.points / np.linalg.norm(rays.points, axis=1)[:, None] @ R.T
    reach = 0.75 * volume.settings.truncation
    x, distance, normal = _meet(volume, measured, direction, reach)
    with np.errstate(invalid="ignore"):
        residual = np.einsum("ij,ij->i", measured - x, normal) + distance
        cosine = -np.einsum("ij,ij->i", direction, normal)
        alike = np.einsum("ij,ij->i", rays.normals @ R.T, normal) > 0.7
        plate = (np.abs(normal[:, 2]) > PLATE_LEVEL) & (x[:, 2] < PLATE_NEAR)
        good = (np.abs(residual) < reach) & (cosine > LEAST_COSINE) & alike & ~plate
    x, normal, residual = x[good], normal[good], residual[good]
    turned, table_normal = x @ back[:3, :3], normal @ back[:3, :3]  # on the table, before its turn is undone
    shared = np.column_stack([np.cross(turned, table_normal)[:, :2], table_normal[:, :2]])
    by_angle = normal[:, 0] * x[:, 1] - normal[:, 1] * x[:, 0]
    sigma = np.maximum(rays.sigma[good] * cosine[good], 1e-5)
    return np.full(len(x), number), x, residual, by_angle, shared, sigma, rays.spoilt[good], rays.pixels[good]


def _meet(volume: Volume, measured: Array, direction: Array, reach: float) -> tuple[Array, Array, Array]:
    """Where rays through measured points (n, 3) meet the model: the place, the field there, its unit normal."""
    x = measured
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(2):
            distance, gradient, _ = volume.sample(x)
            slope = np.einsum("ij,ij->i", gradient, direction)
            step = np.where(slope < -0.5 * LEAST_COSINE, -distance / slope, np.nan)
            x = x + np.clip(step, -3 * reach, 3 * reach)[:, None] * direction
        distance, gradient, _ = volume.sample(x)
        size = np.linalg.norm(gradient, axis=1)
        normal = np.where(size[:, None] > 0.5, gradient / size[:, None], np.nan)
    return x, distance.astype(float), normal.astype(float)


@dataclass(frozen=True)
class _Solution:
    """Steps and their standard deviations (4 + n,): axis, angles."""

    step: Array
    std: Array


def _solve(equations: _Equations, cell: float, n: int) -> _Solution:
    """One Gauss-Newton step; the cells' offsets are eliminated."""
    e = equations
    cells = _numbered(np.floor(e.place / cell).astype(np.int64))
    offset, spread = _offsets(e, cells)
    fits = np.isfinite(spread)
    e = _chosen(e, fits)
    cells, offset, spread = cells[fits], offset[fits], spread[fits]
    rest = (e.residual - offset) / spread
    J = _wide(np.column_stack([e.shared, e.angle]) / spread[:, None], e.frame, n)
    count = int(np.max(cells)) + 1
    member = sparse.csr_matrix((1 / spread, (cells, np.arange(len(cells)))), (count, len(cells)))
    total = np.maximum(np.bincount(cells, spread**-2, count), 1e-12)
    together = member @ J
    H = (J.T @ J - together.T @ sparse.diags(1 / total) @ together).toarray()
    step, std = _step(H, J.T @ rest)
    return _Solution(step, std * _alike(e, rest, spread))


def _numbered(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """A number (m,) from 0 on for each different row of places (m, k), in their order.

    Places are those of one object, so counting them in a grid is quicker than sorting (0.02 s against 1.1 s a million).
    """
    low = places.min(axis=0)
    size = places.max(axis=0) - low + 1
    flat = np.ravel_multi_index(tuple((places - low).T), tuple(size))
    if np.prod(size) > 50e6:  # the grid would cost more than the places
        return np.unique(flat, return_inverse=True)[1]
    return np.asarray(np.cumsum(np.bincount(flat) > 0)[flat] - 1)


def _alike(e: _Equations, rest: Array, spread: Array) -> float:
    """By how much errors that neighbouring pixels share widen the standard deviations (clustered by tiles)."""
    share = rest * e.angle / spread
    tile = np.column_stack([e.frame, e.pixels // TILE])
    tiles = _numbered(tile)
    return max(1.0, float(np.sqrt(np.sum(np.bincount(tiles, share) ** 2) / np.maximum(np.sum(share**2), 1e-300))))


def _offsets(e: _Equations, cells: NDArray[np.int64]) -> tuple[Array, Array]:
    """Offset of each equation's cell (m,) [m], and the spread (m,) [m] its robust weight stands for; NaN is out."""
    count = int(np.max(cells)) + 1
    offset = np.zeros(count)
    spread = np.full(len(cells), np.nan)
    for _ in range(3):
        rest = e.residual - offset[cells]
        scale = max(1.4826 * float(np.median(np.abs(rest) / e.sigma)), 0.1)
        shape = tukey(rest / (scale * e.sigma), CUT)
        weight = shape / (scale * e.sigma) ** 2
        total = np.bincount(cells, weight, count)
        offset = np.bincount(cells, weight * e.residual, count) / np.maximum(total, 1e-12)
        spread = np.where(shape > 1e-3, scale * e.sigma / np.sqrt(np.maximum(shape, 1e-3)), np.nan)
    return offset[cells], spread


def _wide(columns: Array, frame: NDArray[np.int64], n: int) -> sparse.csr_matrix:
    """Columns (m, 4 + 1), the last of which belongs to the frame's own angle, as (m, 4 + n)."""
    m, k = columns.shape
    place = np.column_stack([np.tile(np.arange(SHARED), (m, 1)), SHARED + frame])
    return sparse.csr_matrix((columns.ravel(), place.ravel(), np.arange(0, m * k + 1, k)), (m, SHARED + n))


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
