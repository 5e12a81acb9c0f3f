"""PrimeSense's packing of depth in `.oni` files, 16z: differences from pixel to pixel in half bytes.

A byte below 0xE0 holds two differences, each plus 6, or one and 0xD for nothing; 0xE0 to 0xFE twice as many
repetitions as it exceeds 0xE0; a half byte 0xF, or 0xFF, says that a large step follows: one byte of difference plus
192, or two bytes of the value itself, whose first bit is 0. Found from files of OpenNI's own recorder; "with table"
numbers the values that occur.
"""

import numpy as np
from numpy.typing import NDArray

RUN, LARGE, SINGLE, EMPTY = 0xE0, 0xFF, 0x0F, 0x0D


def unpack(data: bytes, pixels: int) -> NDArray[np.uint16]:
    """(pixels,) values. Raises ValueError where the data are cut off, or hold more or fewer."""
    if len(data) < 2:
        raise ValueError(f"{len(data)} bytes")
    coded = np.frombuffer(data, np.uint8)[2:].astype(np.int64)
    inner, absolute = _large_steps(coded)
    plain = ~inner & (coded < RUN)
    runs = ~inner & (coded >= RUN) & (coded < LARGE)
    low = coded & SINGLE
    steps, times = np.zeros((2, len(coded) + 1, 2), np.int64)
    times[0, 0] = 1  # the first value stands in whole
    steps[1:, 0] = np.where(plain, 6 - (coded >> 4), 0)
    steps[1:, 1] = np.where(plain, 6 - low, 0)
    times[1:, 0] = np.where(plain, 1, np.where(runs, 2 * (coded - RUN), 0))
    times[1:, 1] = plain & (low < EMPTY)
    short = inner & (coded >= 128)
    short[[at + 1 for at, _ in absolute]] = False
    steps[1:, 0][short], times[1:, 0][short] = 192 - coded[short], 1
    given = np.full((len(coded) + 1) * 2, -1, np.int64)
    given[0] = int.from_bytes(data[:2], "little")
    for at, value in absolute:
        given[2 * (at + 1)], times[at + 1, 0] = value, 1
    if int(times.sum()) != pixels:
        raise ValueError(f"{int(times.sum())} of {pixels} pixels")
    sums = np.cumsum(steps.ravel() * (times.ravel() > 0))
    latest = np.maximum.accumulate(np.where(given >= 0, np.arange(len(given)), 0))
    values = given[latest] + sums - sums[latest]
    return np.repeat(values, times.ravel()).astype(np.uint16)


def unpack_with_table(data: bytes, pixels: int) -> NDArray[np.uint16]:
    """The same of numbers of a table of values, which stands before them. Raises ValueError."""
    count = int.from_bytes(data[:2], "little")
    table = np.frombuffer(data[2 : 2 + 2 * count], "<u2")
    if not count or len(table) < count:
        raise ValueError("a table that is cut off")
    numbers = unpack(data[2 + 2 * count :], pixels)
    if numbers.max() >= count:
        raise ValueError(f"number {numbers.max()} of a table of {count}")
    return table[numbers].astype(np.uint16)


def _large_steps(coded: NDArray[np.int64]) -> tuple[NDArray[np.bool_], list[tuple[int, int]]]:
    """Which bytes belong to a large step, and (place of the first byte, value) of those that give the value itself."""
    inner = np.zeros(len(coded), bool)
    absolute = []
    marks = np.flatnonzero(((coded < RUN) & (coded & SINGLE == SINGLE)) | (coded == LARGE)).tolist()
    end = -1  # of the last large step
    for mark in marks:
        at = mark + 1
        if mark <= end or at >= len(coded):  # a byte of another step; the end of the last pair
            continue
        if coded[at] & 128:
            end = at
        else:
            if at + 1 >= len(coded):
                raise ValueError("a step that is cut off")
            end = at + 1
            absolute.append((at, int(coded[at] << 8 | coded[at + 1])))
        inner[at : end + 1] = True
    return inner, absolute
