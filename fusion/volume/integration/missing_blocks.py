# mypy: ignore-errors
"""Which of the blocks that a frame needs are missing."""

from typing import NamedTuple

from fusion.compute.language import I32, I64, func, ti
from fusion.volume.hashing import lookup, pack

FILTER = 1 << 12  # entries of the table that keeps most doublets out of the list of missing blocks


class MissingBlocks(NamedTuple):
    """The list of missing blocks: as many packed coordinates as there is room for, how many there are (1,), and the
    filter (FILTER,) of -1 at the start."""

    keys: I64
    count: I32
    seen: I64


@func
def _want(at: ti.template(), known: ti.template(), missing: ti.template()):
    """Lists a block when it is absent."""
    key = pack(at[0], at[1], at[2])
    h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
    if missing.seen[h] != key and lookup(at[0], at[1], at[2], known.keys, known.ids) < 0:
        missing.seen[h] = key
        n = ti.atomic_add(missing.count[0], 1)
        if n < missing.keys.shape[0]:
            missing.keys[n] = key


@func
def _bits(begin: ti.template(), end: ti.template()):
    """The blocks from begin to end, each of them 0 to 2, as bits in the order of `Blocks.neighbours`."""
    bits = 1
    for a in ti.static(range(3)):  # axis by axis: what is marked so far, at every step from begin to end
        shift = ti.static((9, 3, 1)[a])
        bits <<= shift * begin[a]
        bits |= ti.select(end[a] > begin[a], bits << shift, 0)
        bits |= ti.select(end[a] > begin[a] + 1, bits << shift, 0)
    return bits


@func
def look(begin: ti.template(), end: ti.template(), known: ti.template(), missing: ti.template()):
    """Lists what is absent of the blocks from begin to end."""
    middle, sides, whole = (begin + end) >> 1, end - begin + 1, False
    if sides.max() <= 3:
        n = lookup(middle[0], middle[1], middle[2], known.keys, known.ids)
        if n >= 0:
            whole = (_bits(begin - middle + 1, end - middle + 1) & ~known.around[n]) == 0
    if not whole:
        at = ti.Vector([begin[0], begin[1], begin[2]])
        while at[0] <= end[0]:  # counted by hand: the compiler would write a loop whose length it knows four times
            _want(at, known, missing)
            at[2] += 1
            if at[2] > end[2]:
                at[2] = begin[2]
                at[1] += 1
                if at[1] > end[1]:
                    at[1] = begin[1]
                    at[0] += 1
