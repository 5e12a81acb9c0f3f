# mypy: ignore-errors
"""Loops whose items the pool's threads take in turn, share by share.

Taichi halves a loop beforehand, or cuts it into as many parts as there are cores. Where one of them has more to do, or
runs on a core that something else uses, the others wait for it.
"""

import os
from functools import cache

from fusion.compute.language import ti

SPLIT = 512  # iterations of a parallel loop that the CPU pool never splits
SHARES = 32  # of a loop, on a processor
MANY = 4096  # elsewhere, where each is one of many threads


@cache
def parts() -> int:
    """Iterations of a parallel loop of which each of the pool's threads gets one lot: each takes shares there."""
    return SPLIT * (os.cpu_count() or 1)


@ti.func
def share(turn: ti.template(), total: ti.i32):
    """The first item of the next share, and where it ends; the first is `total` when all are taken.

    Args:
        turn: (1,) an array of 0 at the start.
    """
    first, size = total, total // ti.static(_shares()) + 1
    if turn[0] < total:  # else it would grow without end
        first = ti.min(ti.atomic_add(turn[0], size), total)
    return first, ti.min(first + size, total)


def _shares() -> int:
    return SHARES if ti.lang.impl.current_cfg().arch in (ti.x64, ti.arm64) else MANY
