# mypy: ignore-errors
"""Sparse storage: a growing pool of 8 x 8 x 8 voxel blocks, found through a hash of their coordinates.

A hash and not a dense table of the bounding box: one stray pixel a kilometre away then costs a block and not
gigabytes. Each block also keeps the ids of its 27 neighbours, so interpolation and meshing never hash.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.compute.cards.memory import fetch, keep
from fusion.compute.language import func, ti
from fusion.errors import VolumeError
from fusion.volume.hashing import Hash, HashedBlocks, add, find, packed
from fusion.volume.settings import BLOCK, VOXELS, VolumeSettings

LARGEST = (1 << 31) // (2 * VOXELS) - 1  # blocks that 32 bits can index


class FullError(VolumeError):
    """The blocks do not fit into the memory that they may take."""


@dataclass
class BlockArrays:
    """The arrays of blocks as kernels take them: on a card they stay there, and these are what they were.

    Attributes:
        low, high: (3,) int32 smallest and largest block coordinates.
        keys, ids: (m,) the hash, m a power of two: packed coordinates (-1 = free) and block ids.
        coordinates: (capacity, 3) int32 block coordinates; block (1, 0, 0) begins at voxel (8, 0, 0).
        neighbours: (capacity, 27) int32 ids of the blocks around, -1 = none, index (di+1)*9 + (dj+1)*3 + dk+1.
        around: (capacity,) int32 the same as bits, 1 << index where there is a block: it takes one look to know all.
        flat: (capacity * 64 * 2 * 8,) float32, rows of voxels along z: the sums of weight * distance [m] of all eight,
            then their sums of weight. So a row is 64 bytes, and eight voxels are updated at a time; see `entry`.
        solid: (capacity,) int32, a bit for each octant (4 x 4 x 4 voxels; x, y, z from the highest to the lowest of
            three bits) with a voxel that was ever behind a surface: rays end in these only.
        colors: (capacity, 512, 4) float32: sums of weight * (r, g, b), sum of weight; (1, 1, 4) without colour.
    """

    low: NDArray[np.int32]
    high: NDArray[np.int32]
    keys: NDArray[np.int64]
    ids: NDArray[np.int32]
    coordinates: NDArray[np.int32]
    neighbours: NDArray[np.int32]
    around: NDArray[np.int32]
    flat: NDArray[np.float32]
    solid: NDArray[np.int32]
    colors: NDArray[np.float32]

    @classmethod
    def empty(cls, color: bool) -> "BlockArrays":
        """For no block yet."""
        whole, packed = np.int32, np.full(256, -1, np.int64)
        return cls(
            keep(np.zeros(3, whole)), keep(np.zeros(3, whole)), keep(packed), keep(np.full(256, -1, whole)),
            np.zeros((0, 3), whole), np.zeros((0, 27), whole), np.zeros(0, whole), np.zeros(0, np.float32),
            np.zeros(0, whole), keep(np.zeros((0, VOXELS, 4) if color else (1, 1, 4), np.float32)),
        )  # fmt: skip

    def __getstate__(self) -> dict[str, NDArray[np.generic]]:
        """For a copy, and another process: what kernels made of them."""
        return {name: fetch(array) for name, array in vars(self).items()}

    def __setstate__(self, state: dict[str, NDArray[np.generic]]) -> None:
        vars(self).update({name: keep(array) for name, array in state.items()})


class Blocks:
    """The blocks of a volume.

    Attributes:
        count: blocks in use; the first `count` rows of the arrays.
        arrays: for kernels. For Python `coordinates`, `voxels`, `solid`, `colors`, `low` and `high` are what kernels
            made of them, and what is written to them is what kernels will find.
    """

    def __init__(self, settings: VolumeSettings) -> None:
        self.settings = settings
        self.limit = min(settings.max_bytes // settings.block_bytes, LARGEST)
        self.count = 0
        self.arrays = BlockArrays.empty(settings.color)
        self._reserve(min(64, max(self.limit, 1)))

    @property
    def low(self) -> NDArray[np.int32]:
        """Smallest block coordinates (3,)."""
        return fetch(self.arrays.low)

    @property
    def high(self) -> NDArray[np.int32]:
        """Largest block coordinates (3,)."""
        return fetch(self.arrays.high)

    @property
    def coordinates(self) -> NDArray[np.int32]:
        """(capacity, 3)."""
        return fetch(self.arrays.coordinates)

    @property
    def voxels(self) -> NDArray[np.float32]:
        """(capacity, 64, 2, 8)."""
        return fetch(self.arrays.flat, changed=True).reshape(-1, BLOCK * BLOCK, 2, BLOCK)

    @property
    def solid(self) -> NDArray[np.int32]:
        """(capacity,)."""
        return fetch(self.arrays.solid, changed=True)

    @property
    def colors(self) -> NDArray[np.float32]:
        """(capacity, 512, 4)."""
        return fetch(self.arrays.colors, changed=True)

    @property
    def bytes(self) -> int:
        """Memory of all arrays [bytes]."""
        return sum(array.nbytes for array in vars(self.arrays).values())

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
        a = self.arrays
        if needed > len(a.coordinates):
            self._reserve(min(max(needed, 2 * len(a.coordinates)), self.limit))
        first, self.count = self.count, needed
        rehashed = first
        if 2 * needed > len(a.keys):
            size, rehashed = 1 << int(4 * needed - 1).bit_length(), 0
            a.keys, a.ids = keep(np.full(size, -1, np.int64)), keep(np.full(size, -1, np.int32))
        add(keys, rehashed, first, HashedBlocks(a.coordinates, a.low, a.high, a.neighbours), self.hash())

    def hash(self) -> Hash:
        """Where blocks are, as kernels take it."""
        return Hash(self.arrays.keys, self.arrays.ids, self.arrays.around)

    def mark(self, ids: NDArray[np.int32] | slice) -> None:
        """Bring `solid` up to date after voxels were changed other than by fusing a frame."""
        behind = self.voxels[ids, :, 0].reshape(-1, 2, 4, 2, 4, 2, 4) < 0
        self.solid[ids] = behind.any(axis=(2, 4, 6)).reshape(-1, 8) @ (1 << np.arange(8))

    def find(self, coordinates: NDArray[np.int32]) -> NDArray[np.int32]:
        """Ids (n,) of the blocks at coordinates (n, 3), -1 where there is none."""
        found = np.full(len(coordinates), -1, np.int32)
        if len(coordinates):
            find(np.ascontiguousarray(coordinates, np.int32), self.arrays.keys, self.arrays.ids, found)
        return found

    def _reserve(self, capacity: int) -> None:
        """Move to arrays of a new capacity; pages never written to cost no memory yet."""
        for name in ("coordinates", "neighbours", "around", "flat", "solid", "colors"):
            old = getattr(self.arrays, name)
            if name == "colors" and not self.settings.color:
                continue
            each = 2 * VOXELS if name == "flat" else 1  # numbers of a block along the first axis
            new = np.zeros((capacity * each, *old.shape[1:]), old.dtype)
            new[: self.count * each] = fetch(old)[: self.count * each]
            setattr(self.arrays, name, keep(new))


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
    """Place of voxel o of block n in `BlockArrays.flat`; its weight is 8 further on."""
    return (n << 10) | ((o & ~7) << 1) | (o & 7)
