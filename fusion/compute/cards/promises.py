# mypy: ignore-errors
"""What kernels rely on, tried on a device before anything is computed there.

A device that breaks one of these gives wrong numbers without a word: Mesa 22's software Vulkan loses some of what is
added up in loops of unlike length, so that blocks are missing and neighbours are not found.
"""

import numpy as np

from fusion.compute.language import F32, I32, I64, kernel, ti

MANY = 4096  # more than a device runs at once in one group
UNLIKE = 27  # lengths of loops


@kernel
def trial(values: F32, every: F32, bits: I32, wide: I64, count: I32):
    for n in range(values.shape[0]):
        if n % 2 == 0:
            every[n] = values[n] + 1.0  # NaN stays NaN
        known = values[n] == values[n]
        bits[n] = ti.bit_cast(values[n], ti.i32) if known else -1
        wide[n] = ti.cast(n, ti.i64) << 33
        ti.atomic_add(count[0], 1)
        for _ in range(n % UNLIKE):
            ti.atomic_add(count[1], 1)


def broken_promise(run=trial) -> str:
    """What the device that runs does not hold to, in a few words; "" where it holds to all that is tried."""
    values = np.linspace(-1, 1, MANY).astype(np.float32)
    values[::3] = np.nan
    every, bits = np.full(MANY, 7, np.float32), np.zeros(MANY, np.int32)
    wide, count = np.zeros(MANY, np.int64), np.zeros(2, np.int32)
    run(values, every, bits, wide, count)
    held = {
        "what a kernel leaves unwritten is lost": (every[1::2] == 7).all(),
        "sums are wrong": np.array_equal(every[::2], values[::2] + 1, equal_nan=True),
        "missing values (NaN) are taken for numbers": np.array_equal(bits == -1, np.isnan(values)),
        "bits of numbers are lost": np.array_equal(bits[bits != -1], values[~np.isnan(values)].view(np.int32)),
        "whole numbers of 64 bits are cut": np.array_equal(wide, np.arange(MANY, dtype=np.int64) << 33),
        "threads do not count together": count[0] == MANY,
        "what is added up in loops of unlike length is lost": count[1] == (np.arange(MANY) % UNLIKE).sum(),
    }
    return next((what for what, good in held.items() if not good), "")
