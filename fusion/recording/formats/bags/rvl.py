"""RVL, the lossless packing of depth that some recorders use.

A. D. Wilson, Fast Lossless Depth Image Compression, 2017.

Words of 32 bit hold nibbles, the highest first; a nibble is three bits of a value and a mark that more follow. Values
are: how many zeros, how many others, and of these the difference to the one before, with its sign in the lowest bit.
"""

import numpy as np
from numpy.typing import NDArray

LONGEST = 7  # nibbles of a value: twenty-one bits, more than any count of pixels that a limit lets through


def unpack_rvl(data: bytes, width: int, height: int) -> NDArray[np.uint16]:
    """Counts (height, width) of packed depth.

    Raises:
        ValueError: the data end before the pixels do, or lead beyond them.
    """
    pixels = width * height
    values = _values(data)
    counts = np.zeros(pixels, np.uint16)
    filled: list[NDArray[np.int64]] = []
    places: list[tuple[int, int]] = []
    at = pixel = 0
    while pixel < pixels:
        if at + 2 > len(values):
            raise ValueError(f"RVL data that end at pixel {pixel} of {pixels}")
        zeros, others = int(values[at]), int(values[at + 1])
        at += 2
        pixel += zeros
        if pixel + others > pixels or at + others > len(values) or zeros + others == 0:
            raise ValueError(f"RVL data that lead beyond pixel {pixel} of {pixels}")
        filled.append(values[at : at + others])
        places.append((pixel, others))
        at += others
        pixel += others
    if filled:
        steps = np.concatenate(filled)
        depths = np.cumsum((steps >> 1) ^ -(steps & 1))
        begin = 0
        for pixel, others in places:
            counts[pixel : pixel + others] = depths[begin : begin + others].astype(np.uint16)
            begin += others
    return counts.reshape(height, width)


def _values(data: bytes) -> NDArray[np.int64]:
    """All values of the stream, one after the other."""
    words = np.frombuffer(data, "<u4", len(data) // 4)
    shifts = np.arange(28, -4, -4, dtype=np.uint32)
    nibbles = ((words[:, None] >> shifts) & 15).astype(np.int64).reshape(-1)
    ends = np.flatnonzero((nibbles & 8) == 0)
    if not len(ends):
        return np.zeros(0, np.int64)
    starts = np.concatenate([[0], ends[:-1] + 1])
    if (ends - starts).max() >= LONGEST:
        raise ValueError("RVL data with a value that does not end")
    nibbles = nibbles[: ends[-1] + 1]
    order = np.arange(len(nibbles)) - np.repeat(starts, ends - starts + 1)
    return np.asarray(np.add.reduceat((nibbles & 7) << (3 * order), starts), np.int64)
