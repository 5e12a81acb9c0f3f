# mypy: ignore-errors
"""Whether a card is worth taking: it holds to what kernels rely on, and is faster than the processor beside it.

`FUSION_DEVICE=vulkan python -m fusion.compute.cards.self_check` prints how many times as fast; it fails where there is
no such card or where it computes wrong. It runs in a process of its own, as a back end is started once in a process,
and as a driver that is broken may end it.
"""

import sys
import time

import numpy as np

from fusion.compute.back_end import init, ti
from fusion.compute.cards import memory
from fusion.compute.language import F32, kernel
from fusion.compute.start import start

ITEMS, STEPS, ROUNDS = 1 << 19, 256, 5


@kernel
def _work(values: F32):
    for n in range(values.shape[0]):
        x = values[n]
        for _ in range(STEPS):
            x = x * 0.999 + 0.001
        values[n] = x


def times_as_fast() -> float:
    """The card that FUSION_DEVICE names beside the processor; the process has the processor afterwards.

    Raises:
        FusionError: there is no such card, or it computes wrong.
    """
    start()
    there = _seconds()
    init(arch=ti.cpu, log_level=ti.ERROR)
    return _seconds() / there


def _seconds() -> float:
    """What a round takes, the least of some."""
    values, taken = memory.keep(np.zeros(ITEMS, np.float32)), []
    for _ in range(ROUNDS + 1):  # the first compiles
        began = time.perf_counter()
        _work(values)
        ti.sync()
        taken.append(time.perf_counter() - began)
    return min(taken[1:])


if __name__ == "__main__":
    sys.stdout.write(f"{times_as_fast():.2f}\n")
