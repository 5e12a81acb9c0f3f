# mypy: ignore-errors
"""Blocks are found through a hash of their coordinates: places in a row until the block, or a free one."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import I32, I32_2, I64, func, kernel, ti
from fusion.volume.settings import LATTICE


def packed(coordinates: NDArray[np.integer]) -> NDArray[np.int64]:
    """Keys (n,) of block coordinates (n, 3)."""
    x, y, z = coordinates.astype(np.int64).T + LATTICE
    return x << 42 | y << 21 | z


@func
def pack(x: ti.i32, y: ti.i32, z: ti.i32) -> ti.i64:
    """Key of a block."""
    return (ti.cast(x + LATTICE, ti.i64) << 42) | (ti.cast(y + LATTICE, ti.i64) << 21) | ti.cast(z + LATTICE, ti.i64)


@func
def slot(x: ti.i32, y: ti.i32, z: ti.i32, size: ti.i32) -> ti.i32:
    """First place to look at in a hash of a power-of-two size."""
    h = (x * 73856093) ^ (y * 19349669) ^ (z * 83492791)
    return (h ^ (h >> 13)) & (size - 1)


@func
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


class Hash(NamedTuple):
    """Where blocks are, see `Blocks`."""

    keys: I64
    ids: I32
    around: I32


class HashedBlocks(NamedTuple):
    """The blocks themselves, see `Blocks`."""

    coordinates: I32_2
    low: I32
    high: I32
    neighbours: I32_2


@kernel
def find(coordinates: I32_2, keys: I64, ids: I32, found: I32):
    for n in range(coordinates.shape[0]):
        found[n] = lookup(coordinates[n, 0], coordinates[n, 1], coordinates[n, 2], keys, ids)


@kernel
def add(added: I64, first: ti.i32, new: ti.i32, places: HashedBlocks, known: Hash):
    """Unpack the new blocks, hash those from the first on, and link the new ones; one after the other, as threads wake
    late for a few."""
    coordinates, low, high, neighbours = ti.static((places.coordinates, places.low, places.high, places.neighbours))
    keys, ids, around = ti.static((known.keys, known.ids, known.around))
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
