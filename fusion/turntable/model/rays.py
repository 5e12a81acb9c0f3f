"""What each frame of a turntable scan shows of the object, pixel by pixel, for the fit against the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.turntable.model.rough import HALF, shared_errors
from fusion.turntable.selfcheck import SelfCheck

TILE = 16  # [px] farther apart than this, errors are taken as independent (guess)


@dataclass(frozen=True)
class Rays:
    """What one frame shows of the object.

    Attributes:
        values: (n, 8) point in the camera [m], normal, standard deviation of the depth [m], and by how much the
            errors of rough places (see `shared_errors`) widen it.
        tiles: (n, 2) row and column of the tile in which neighbours' errors are alike.
    """

    values: NDArray[np.float32]
    tiles: NDArray[np.int32]


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
