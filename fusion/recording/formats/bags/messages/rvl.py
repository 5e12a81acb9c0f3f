# mypy: ignore-errors
"""RVL, the lossless packing of depth that some recorders use.

A. D. Wilson, Fast Lossless Depth Image Compression, 2017.

Words of 32 bit hold nibbles, the highest first; a nibble is three bits of a value and a mark that more follow. Values
are: how many zeros, how many others, and of these the difference to the one before, with its sign in the lowest bit.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import I32, func, kernel, ti
from fusion.compute.start import start

LONGEST = 7  # nibbles of a value: twenty-one bits, more than any count of pixels that a limit lets through
WHOLE, ENDED, ENDLESS, BEYOND = range(4)
SAID = {ENDED: "that end at", ENDLESS: "with a value that does not end at", BEYOND: "that lead beyond"}


def unpack_rvl(data: bytes, width: int, height: int) -> NDArray[np.uint16]:
    """Counts (height, width) of packed depth. ValueError: the data end before the pixels do, or lead beyond them."""
    pixels = width * height
    words = np.frombuffer(data, "<i4", len(data) // 4).astype(np.int32)
    counts, told = np.zeros(pixels, np.int32), np.zeros(2, np.int32)
    if not pixels:
        return counts.astype(np.uint16).reshape(height, width)
    start()
    _unpack(words if len(words) else np.zeros(1, np.int32), 8 * len(words), pixels, counts, told)
    if told[0] != WHOLE:
        raise ValueError(f"RVL data {SAID[int(told[0])]} pixel {told[1]} of {pixels}")
    return counts.astype(np.uint16).reshape(height, width)


@func
def _value(words: ti.template(), nibbles: ti.i32, at: ti.i32):
    """The value that begins at a nibble, where the next one begins, and whether it is whole."""
    value, shift, more, told = 0, 0, True, WHOLE
    while more:
        if at >= nibbles or shift >= 3 * LONGEST:
            told, more = ti.select(at >= nibbles, ENDED, ENDLESS), False
        else:
            nibble = (words[at >> 3] >> (28 - 4 * (at & 7))) & 15
            value, shift, at, more = value | ((nibble & 7) << shift), shift + 3, at + 1, nibble > 7
    return value, at, told


@kernel
def _unpack(words: I32, nibbles: ti.i32, pixels: ti.i32, counts: I32, told: I32):
    """Fill `counts` (pixels,); told: what went wrong, and at which pixel."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        at, pixel, depth, wrong = 0, 0, 0, WHOLE
        while pixel < pixels and wrong == WHOLE:
            zeros, behind, first = _value(words, nibbles, at)
            others, begin, second = _value(words, nibbles, behind)
            wrong, at = ti.max(first, second), begin
            if wrong == WHOLE and (pixel + zeros + others > pixels or zeros + others == 0):
                wrong = BEYOND
            if wrong == WHOLE:
                pixel += zeros
                while others > 0 and wrong == WHOLE:
                    step, after, whole = _value(words, nibbles, at)
                    depth += (step >> 1) ^ -(step & 1)
                    counts[pixel] = depth & 65535
                    pixel, others, at, wrong = pixel + 1, others - 1, after, whole
        told[0], told[1] = wrong, pixel
