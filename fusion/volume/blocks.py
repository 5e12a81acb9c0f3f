# mypy: ignore-errors
"""Sparse storage: a growing pool of 8 x 8 x 8 voxel blocks, found through a hash of their coordinates.

A hash and not a dense table of the bounding box: one stray pixel a kilometre away then costs a block and not
gigabytes. Each block also keeps the ids of its 27 neighbours, so interpolation and meshing never hash.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import ti
from fusion.errors import VolumeError
from fusion.volume.settings import BLOCK, LATTICE, VOXELS, VolumeSettings

I32 = ti.types.ndarray(ti.i32, 1)
I32_2 = ti.types.ndarray(ti.i32, 2)
I64 = ti.types.ndarray(ti.i64, 1)
F32 = ti.types.ndarray(ti.f32, 1)
F32_2 = ti.types.ndarray(ti.f32, 2)
F32_3 = ti.types.ndarray(ti.f32, 3)
LARGEST = (1 << 31) // (2 * VOXELS) - 1  # blocks that 32 bits can index


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
            then their sums of weight. So a row is one cache line, and eight voxels are updated at a time.
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
        self.insert_keys(_pack(coordinates))

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
        _add(
            keys, rehashed, first, self.coordinates, self.low, self.high, self.keys, self.ids, self.neighbours,
            self.around,
        )  # fmt: skip

    def mark(self, ids: NDArray[np.int32] | slice) -> None:
        """Bring `solid` up to date after voxels were changed other than by fusing a frame."""
        behind = self.voxels[ids, :, 0].reshape(-1, 2, 4, 2, 4, 2, 4) < 0
        self.solid[ids] = behind.any(axis=(2, 4, 6)).reshape(-1, 8) @ (1 << np.arange(8))

    def find(self, coordinates: NDArray[np.int32]) -> NDArray[np.int32]:
        """Ids (n,) of the blocks at coordinates (n, 3), -1 where there is none."""
        found = np.full(len(coordinates), -1, np.int32)
        if len(coordinates):
            _find(np.ascontiguousarray(coordinates, np.int32), self.keys, self.ids, found)
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


def _pack(coordinates: NDArray[np.integer]) -> NDArray[np.int64]:
    """Keys (n,) of block coordinates (n, 3)."""
    x, y, z = coordinates.astype(np.int64).T + LATTICE
    return x << 42 | y << 21 | z


def _full(settings: VolumeSettings, needed: int) -> VolumeError:
    # at a fixed truncation in voxels the number of blocks goes with 1 / voxel^2
    fits = settings.voxel * np.sqrt(needed * settings.block_bytes / settings.max_bytes) * 1.05
    return VolumeError(
        "the volume does not fit into its memory",
        found=f"at least {needed} blocks = {needed * settings.block_bytes / 2**20:.0f} MiB needed",
        expected=f"at most {settings.max_bytes / 2**20:.0f} MiB",
        do=f"take voxels of at least {np.ceil(fits * 4000) / 4:g} mm, set bounds, or allow more memory",
    )


@ti.func
def entry(n: ti.i32, o: ti.i32) -> ti.i32:
    """Place of voxel o of block n in `Blocks.flat`; its weight is 8 further on."""
    return (n << 10) | ((o & ~7) << 1) | (o & 7)


@ti.func
def pack(x: ti.i32, y: ti.i32, z: ti.i32) -> ti.i64:
    """Key of a block."""
    return (ti.cast(x + LATTICE, ti.i64) << 42) | (ti.cast(y + LATTICE, ti.i64) << 21) | ti.cast(z + LATTICE, ti.i64)


@ti.func
def slot(x: ti.i32, y: ti.i32, z: ti.i32, size: ti.i32) -> ti.i32:
    """First place to look at in a hash of a power-of-two size."""
    h = (x * 73856093) ^ (y * 19349669) ^ (z * 83492791)
    return (h ^ (h >> 13)) & (size - 1)


@ti.func
def lookup(x: ti.i32, y: ti.i32, z: ti.i32, keys: ti.template(), ids: ti.template()) -> ti.i32:
    """Id of the block at (x, y, z), -1 when there is none."""
    key = pack(x, y, z)
    size = keys.shape[0]
    h = slot(x, y, z, size)
    found = -1
    seen = keys[h]
    while seen != -1:
        if seen == key:
            found = ids[h]
            break
        h = (h + 1) & (size - 1)
        seen = keys[h]
    return found


@ti.kernel
def _find(coordinates: I32_2, keys: I64, ids: I32, found: I32):
    for n in range(coordinates.shape[0]):
        found[n] = lookup(coordinates[n, 0], coordinates[n, 1], coordinates[n, 2], keys, ids)


@ti.kernel
def _add(
    added: I64, first: ti.i32, new: ti.i32, coordinates: I32_2, low: I32, high: I32, keys: I64, ids: I32,
    neighbours: I32_2, around: I32,
):  # fmt: skip
    """Unpack the new blocks, hash those from the first on, and link the new ones; one after the other, as threads wake
    late for a few."""
    # Each turn looks at one place of the hash: the compiler would write loops within loops up to eight times.
    size, end = keys.shape[0], new + added.shape[0]
    n, h, key = first, -1, ti.cast(0, ti.i64)
    while n < end:
        if h < 0:
            if n >= new:
                key = added[n - new]
                c = ti.Vector([ti.cast((key >> s) & ((1 << 21) - 1), ti.i32) - LATTICE for s in ti.static((42, 21, 0))])
                for a in ti.static(range(3)):
                    coordinates[n, a] = c[a]
                    low[a] = ti.select(n == 0, c[a], ti.min(low[a], c[a]))
                    high[a] = ti.select(n == 0, c[a], ti.max(high[a], c[a]))
            x, y, z = coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]
            key, h = pack(x, y, z), slot(x, y, z, size)
        if keys[h] == -1:
            keys[h], ids[h] = key, n
            n, h = n + 1, -1
        else:
            h = (h + 1) & (size - 1)
    m = new * 27  # 27 neighbours of each
    while m < end * 27:
        n, o = m // 27, m % 27
        if h < 0:
            x, y = coordinates[n, 0] + o // 9 - 1, coordinates[n, 1] + o // 3 % 3 - 1
            z = coordinates[n, 2] + o % 3 - 1
            inside = ti.max(ti.abs(x), ti.abs(y), ti.abs(z)) < LATTICE
            key, h = ti.select(inside, pack(x, y, z), ti.cast(-2, ti.i64)), slot(x, y, z, size)
        seen = keys[h]
        if seen == key or seen == -1:
            other = ti.select(seen == key, ids[h], -1)
            neighbours[n, o] = other
            if other >= 0:
                neighbours[other, 26 - o] = n
                around[n] = around[n] | (1 << o)
                around[other] = around[other] | (1 << (26 - o))
            m, h = m + 1, -1
        else:
            h = (h + 1) & (size - 1)
