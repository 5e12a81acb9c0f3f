# mypy: ignore-errors
"""Sparse storage: a growing pool of 8 x 8 x 8 voxel blocks, found through a hash of their coordinates.

A hash and not a dense table of the bounding box: one stray pixel a kilometre away then costs a block and not
gigabytes. Each block also keeps the ids of its 27 neighbours, so interpolation and meshing never hash.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import func, ti
from fusion.errors import VolumeError
from fusion.volume.hashing import Hash, HashedBlocks, add, find, packed
from fusion.volume.settings import BLOCK, VOXELS, VolumeSettings

LARGEST = (1 << 31) // (2 * VOXELS) - 1  # blocks that 32 bits can index


class FullError(VolumeError):
    """The blocks do not fit into the memory that they may take."""


class Blocks:
    """The blocks of a volume.

    Attributes:
        count: blocks in use; the first `count` rows of the arrays below.
        low, high: (3,) int32 smallest and largest block coordinates.
        keys, ids: (m,) the hash, m a power of two: packed coordinates (-1 = free) and block ids.
        coordinates: (capacity, 3) int32 block coordinates; block (1, 0, 0) begins at voxel (8, 0, 0).
        neighbours: (capacity, 27) int32 ids of the blocks around, -1 = none, index (di+1)*9 + (dj+1)*3 + dk+1.
        around: (capacity,) int32 the same as bits, 1 << index where there is a block: it takes one look to know all.
        voxels: (capacity, 64, 2, 8) float32, rows of voxels along z: the sums of weight * distance [m] of all eight,
            then their sums of weight. So a row is 64 bytes, and eight voxels are updated at a time.
        flat: the same in one dimension, as kernels take it; see `entry`.
        solid: (capacity,) int32, a bit for each octant (4 x 4 x 4 voxels; x, y, z from the highest to the lowest of
            three bits) with a voxel that was ever behind a surface: rays end in these only.
        colors: (capacity, 512, 4) float32: sums of weight * (r, g, b), sum of weight; (1, 1, 4) without colour.
    """

    def __init__(self, settings: VolumeSettings) -> None:
        self.settings = settings
        self.limit = min(settings.max_bytes // settings.block_bytes, LARGEST)
        self.count = 0
        self.low, self.high = np.zeros(3, np.int32), np.zeros(3, np.int32)
        self.keys: NDArray[np.int64] = np.full(256, -1, np.int64)
        self.ids: NDArray[np.int32] = np.full(256, -1, np.int32)
        self.coordinates: NDArray[np.int32] = np.zeros((0, 3), np.int32)
        self.neighbours: NDArray[np.int32] = np.zeros((0, 27), np.int32)
        self.around: NDArray[np.int32] = np.zeros(0, np.int32)
        self.voxels: NDArray[np.float32] = np.zeros((0, BLOCK * BLOCK, 2, BLOCK), np.float32)
        self.solid: NDArray[np.int32] = np.zeros(0, np.int32)
        self.colors: NDArray[np.float32] = np.zeros((0, VOXELS, 4) if settings.color else (1, 1, 4), np.float32)
        self._reserve(min(64, max(self.limit, 1)))

    @property
    def bytes(self) -> int:
        """Memory of all arrays [bytes]."""
        index = (self.keys, self.ids, self.coordinates, self.neighbours, self.around)
        return sum(array.nbytes for array in (*index, self.voxels, self.solid, self.colors))

    def insert(self, coordinates: NDArray[np.int32]) -> None:
        """Add empty blocks at coordinates (n, 3) that are distinct and not yet there.

        Raises:
            VolumeError: they do not fit into `max_bytes`; nothing is added then.
        """
        self.insert_keys(packed(coordinates))

    def insert_keys(self, keys: NDArray[np.int64]) -> None:
        """The same with packed coordinates (n,)."""
        needed = self.count + len(keys)
        if needed > self.limit:
            raise _full(self.settings, needed)
        if needed > len(self.coordinates):
            self._reserve(min(max(needed, 2 * len(self.coordinates)), self.limit))
        first, self.count = self.count, needed
        rehashed = first
        if 2 * needed > len(self.keys):
            size, rehashed = 1 << int(4 * needed - 1).bit_length(), 0
            self.keys, self.ids = np.full(size, -1, np.int64), np.full(size, -1, np.int32)
        places = HashedBlocks(self.coordinates, self.low, self.high, self.neighbours)
        add(keys, rehashed, first, places, Hash(self.keys, self.ids, self.around))

    def mark(self, ids: NDArray[np.int32] | slice) -> None:
        """Bring `solid` up to date after voxels were changed other than by fusing a frame."""
        behind = self.voxels[ids, :, 0].reshape(-1, 2, 4, 2, 4, 2, 4) < 0
        self.solid[ids] = behind.any(axis=(2, 4, 6)).reshape(-1, 8) @ (1 << np.arange(8))

    def find(self, coordinates: NDArray[np.int32]) -> NDArray[np.int32]:
        """Ids (n,) of the blocks at coordinates (n, 3), -1 where there is none."""
        found = np.full(len(coordinates), -1, np.int32)
        if len(coordinates):
            find(np.ascontiguousarray(coordinates, np.int32), self.keys, self.ids, found)
        return found

    def _reserve(self, capacity: int) -> None:
        """Move to arrays of a new capacity; pages never written to cost no memory yet."""
        for name in ("coordinates", "neighbours", "around", "voxels", "solid", "colors"):
            old = getattr(self, name)
            if name == "colors" and not self.settings.color:
                continue
            new = np.zeros((capacity, *old.shape[1:]), old.dtype)
            new[: self.count] = old[: self.count]
            setattr(self, name, new)
        self.flat = self.voxels.reshape(-1)


def by_voxel(voxels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Rows (n, 64, 2, 8) as (n, 512, 2): sum of weight * distance and sum of weight of each voxel, z fastest."""
    return np.ascontiguousarray(voxels.swapaxes(2, 3)).reshape(-1, VOXELS, 2)


def by_row(voxels: NDArray[np.float32]) -> NDArray[np.float32]:
    """The way back from `by_voxel`."""
    return voxels.reshape(-1, BLOCK * BLOCK, BLOCK, 2).swapaxes(2, 3)


def _full(settings: VolumeSettings, needed: int) -> FullError:
    # at a fixed truncation in voxels the number of blocks goes with 1 / voxel^2
    fits = settings.voxel * np.sqrt(needed * settings.block_bytes / settings.max_bytes) * 1.05
    return FullError(
        "the volume does not fit into its memory",
        found=f"at least {needed} blocks = {needed * settings.block_bytes / 2**20:.0f} MiB needed",
        expected=f"at most {settings.max_bytes / 2**20:.0f} MiB",
        do=f"take voxels of at least {np.ceil(fits * 4000) / 4:g} mm, set bounds, or allow more memory",
    )


@func
def entry(n: ti.i32, o: ti.i32) -> ti.i32:
    """Place of voxel o of block n in `Blocks.flat`; its weight is 8 further on."""
    return (n << 10) | ((o & ~7) << 1) | (o & 7)
