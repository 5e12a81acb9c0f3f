"""What each frame of a turntable scan shows of the object, pixel by pixel, for the fit against the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32_2, F64_2, U8_2, kernel, ti
from fusion.compute.start import start
from fusion.geometry.camera import Principle
from fusion.geometry.depth import PointMap
from fusion.turntable.selfcheck import SelfCheck

TILE = 16  # [px] farther apart than this, errors are taken as independent (guess)
HALF = 3  # [px] of the window: a matching window and its surroundings (guess: with 2, steps are taken for slopes)
SURE = 2.0  # standard deviations of the scatter that noise alone leaves
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rays:
    """What one frame shows of the object."""

    # (n, 8) point in the camera [m], normal (NaN beside a rim), standard deviation of the depth [m], by how much the
    # errors of rough places (see `shared_errors`) widen it; inf where the axis must not hang on it
    values: NDArray[np.float32]
    tiles: NDArray[np.int32]  # (n, 2) row and column of the tile in which neighbours' errors are alike


@dataclass(frozen=True)
class Bundle:
    """The rays of all n frames, m of them: `values` (m, 8) and `tiles` (m, 2) as in `Rays`, and their frames (m,)."""

    frame: NDArray[np.int32]
    values: NDArray[np.float32]
    tiles: NDArray[np.int32]
    n: int

    def thinned(self, most: int) -> "Bundle":
        """About `most` of the rays, evenly from all frames."""
        taken = np.arange(0, len(self.frame), max(1, len(self.frame) // most))
        return Bundle(self.frame[taken], self.values[taken], self.tiles[taken], self.n)

    def without(self, check: SelfCheck) -> "Bundle":
        """With these errors of depth taken out; itself where there are none."""
        if not check.wrong_depth:
            return self
        return replace(self, values=np.column_stack([check.points(self.values[:, :3]), self.values[:, 3:]]))


def rays_of(surface: PointMap, usable: NDArray[np.bool_], most: int = 20_000) -> Rays:
    """The usable pixels (h, w) of a surface, on a coarser grid where they are more than `most`."""
    stride = max(1, int(np.ceil(np.sqrt(usable.sum() / most))))
    known = usable & np.isfinite(surface.sigma)
    grid = np.zeros_like(usable)
    grid[::stride, ::stride] = known[::stride, ::stride]
    # n pixels with a common error tell as little as one with it: n of them weigh 1 / (noise + n * common) each
    together = ((2 * HALF + 1) / stride) ** 2
    common = shared_errors(surface.points[..., 2], surface.sigma, known)[grid]
    spoilt = np.sqrt(1 + together * common)
    if surface.camera.principle != Principle.TIME_OF_FLIGHT:  # a matching window at a rim sees one side of its pixel
        spoilt[~np.isfinite(surface.normals[grid][:, 0])] = np.inf
    values = np.column_stack([surface.points[grid], surface.normals[grid], surface.sigma[grid], spoilt])
    return Rays(values.astype(np.float32), (np.argwhere(grid) // (stride * TILE)).astype(np.int32))


def bundle(rays: Sequence[Rays | None]) -> Bundle:
    """The rays of all frames, one frame after the other; None for a frame that takes no part."""
    shown = [(i, r) for i, r in enumerate(rays) if r is not None]
    return Bundle(
        np.concatenate([np.full(len(r.values), i, np.int32) for i, r in shown]),
        np.concatenate([r.values for _, r in shown]),
        np.concatenate([r.tiles for _, r in shown]),
        len(rays),
    )


def shared_errors(depth: NDArray[np.float32], sigma: NDArray[np.float32], taken: NDArray[np.bool_]) -> Array:
    """Variance (h, w) of the error that a pixel shares with its window, over that of the noise; 0 in smooth places.

    Matching windows tear steep surfaces into steps, and mixed pixels bend what borders on an edge: many pixels read
    nearer or farther at a time. Such errors follow the view as the object turns, and so push the axis (measured on the
    statue of the open challenges: 0.4 mm). The noise is what half of the pixels do not exceed, so a sigma that is wrong
    as a whole changes nothing.

    Args:
        depth, sigma: (h, w) [m].
        taken: (h, w) pixels of the surface; others say nothing.
    """
    start()
    scatter, count = np.full(depth.shape, np.nan), np.ones(depth.shape)
    _scatter(np.ascontiguousarray(depth, np.float32), taken.astype(np.uint8), scatter, count)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = scatter / np.square(sigma, dtype=float)
    known = np.isfinite(ratio)
    excess = np.zeros(depth.shape)
    if known.any():
        typical = max(float(np.median(ratio[known])), 1e-12)
        excess[known] = np.maximum(ratio[known] / typical - 1 - SURE * np.sqrt(2 / count[known]), 0)
    return excess


@kernel
def _scatter(depth: F32_2, taken: U8_2, scatter: F64_2, count: F64_2):
    """Variance [m^2] of the taken depths about their plane, and their number, in the window of each taken pixel; NaN
    where they are too few or lie in a row, through which there is no plane."""
    for v0, u0 in ti.ndrange(depth.shape[0], depth.shape[1]):
        if taken[v0, u0] == 1:
            zero = ti.cast(0.0, ti.f64)
            n, u, v, z, uu, vv, uv, uz, vz, zz = zero, zero, zero, zero, zero, zero, zero, zero, zero, zero
            for j in range(ti.max(v0 - HALF, 0), ti.min(v0 + HALF + 1, depth.shape[0])):
                for i in range(ti.max(u0 - HALF, 0), ti.min(u0 + HALF + 1, depth.shape[1])):
                    if taken[j, i] == 1:
                        x, y = ti.cast(i - u0, ti.f64), ti.cast(j - v0, ti.f64)
                        d = ti.cast(depth[j, i], ti.f64) - depth[v0, u0]
                        n, u, v, z = n + 1, u + x, v + y, z + d
                        uu, vv, uv = uu + x * x, vv + y * y, uv + x * y
                        uz, vz, zz = uz + x * d, vz + y * d, zz + d * d
            u, v, z = u / n, v / n, z / n
            uu, vv, uv = uu / n - u * u, vv / n - v * v, uv / n - u * v
            uz, vz, zz = uz / n - u * z, vz / n - v * z, zz / n - z * z
            area = uu * vv - uv * uv
            if n > 3 and area > 1e-6:
                explained = (uz * (uz * vv - vz * uv) + vz * (vz * uu - uz * uv)) / area
                scatter[v0, u0] = ti.max(zz - explained, 0.0) * n / (n - 3)
                count[v0, u0] = n
