"""The field of a volume as plain arrays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import VolumeError
from fusion.geometry.pose import Array
from fusion.volume.blocks import Blocks, by_voxel
from fusion.volume.settings import BLOCK

Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # low and high corner [m]


@dataclass(frozen=True)
class DenseField:
    """Every voxel of a box; element (i, j, k) is the sample at origin + (i, j, k) * voxel in the world.

    Attributes:
        origin: (3,) [m] of element (0, 0, 0).
        voxel: [m] between neighbours.
        distance: (nx, ny, nz) float32, truncated signed distance [m], positive in front of the surface; NaN where
            nothing was ever seen.
        weight: (nx, ny, nz) float32, sum of the weights of all looks; 0 where nothing was seen.
    """

    origin: Array
    voxel: float
    distance: NDArray[np.float32]
    weight: NDArray[np.float32]

    def __repr__(self) -> str:
        size = " x ".join(map(str, self.distance.shape))
        seen = np.count_nonzero(self.weight) / max(self.weight.size, 1)
        return f"<DenseField: {size} voxels of {self.voxel * 1e3:g} mm, {seen:.1%} of them seen>"


def dense(blocks: Blocks, box: Box | None = None) -> DenseField:
    """The voxels within a box of two corners (3,), (3,) [m]; None takes all blocks in use.

    Raises:
        VolumeError: corners that are no box, or arrays larger than the volume's own limit.
    """
    voxel, used = blocks.settings.voxel, blocks.coordinates[: blocks.count]
    first, last = (BLOCK * blocks.low, BLOCK * blocks.high + BLOCK - 1) if box is None else _within(box, voxel)
    shape = last - first + 1 if box is not None or blocks.count else np.zeros(3, np.int64)
    _check_size(shape, blocks)
    # whole blocks first, then cut to the box
    start = first // BLOCK
    count = -(-(first + shape) // BLOCK) - start
    inside = ((used >= start) & (used < start + count)).all(axis=1)
    x, y, z = (used[inside] - start).T
    whole = np.zeros((count[0], BLOCK, count[1], BLOCK, count[2], BLOCK, 2), np.float32)
    whole[x, :, y, :, z] = by_voxel(blocks.voxels[: blocks.count][inside]).reshape(-1, BLOCK, BLOCK, BLOCK, 2)
    cut = tuple(slice(a, a + n) for a, n in zip(first - BLOCK * start, shape, strict=True))
    total, weight = np.moveaxis(whole.reshape(*(BLOCK * count), 2)[cut], -1, 0)
    with np.errstate(invalid="ignore"):
        distance = np.where(weight > 0, total / weight, np.float32(np.nan))
    return DenseField(np.asarray(first * voxel, float), voxel, distance, np.ascontiguousarray(weight))


def _within(box: Box, voxel: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last voxel of a box; one on its face is within, whatever its last digit."""
    corners = np.asarray(box, float)
    if corners.shape != (2, 3) or not np.isfinite(corners).all():
        raise VolumeError("the box is not usable", found=box, expected="two corners of three finite numbers [m]")
    first = np.ceil(corners[0] / voxel - 1e-6).astype(np.int64)
    last = np.floor(corners[1] / voxel + 1e-6).astype(np.int64)
    if (last < first).any():
        raise VolumeError("the box holds no voxel", found=box, expected=f"low and high corner, {voxel} m apart or more")
    return first, last


def _check_size(shape: NDArray[np.int64], blocks: Blocks) -> None:
    # sums of weight * distance and of weight, then distance and weight: four numbers of four bytes each
    needed = 16.0 * np.prod(shape.astype(float))
    if needed > blocks.settings.max_bytes:
        raise VolumeError(
            "the box does not fit into the volume's memory",
            found=f"{' x '.join(map(str, shape))} voxels = {needed / 2**20:.0f} MiB",
            expected=f"at most {blocks.settings.max_bytes / 2**20:.0f} MiB",
            do="take a smaller box",
        )
