# mypy: ignore-errors
"""Loops whose items the pool's threads take in turn, share by share.

Taichi halves a loop beforehand, or cuts it into as many parts as there are cores. Where one of them has more to do, or
runs on a core that something else uses, the others wait for it.
"""

import os
from functools import cache
from typing import NamedTuple

import numpy as np

from fusion.compute.back_end import PROCESSORS
from fusion.compute.language import I32, func, ti

SPLIT = 512  # iterations of a parallel loop that the CPU pool never splits
SHARES = 32  # of a loop, on a processor
MANY = 4096  # elsewhere, where each is one of many threads


class Deal(NamedTuple):
    """What a kernel takes to deal a loop out: whose turn it is (1,), and the iterations of the loop around."""

    turn: I32
    parts: ti.i32


def dealt() -> Deal:
    """For one call."""
    return Deal(np.zeros(1, np.int32), parts())


@cache
def parts() -> int:
    """Iterations of a parallel loop of which each of the pool's threads gets one lot: each takes shares there."""
    return SPLIT * (os.cpu_count() or 1)


@func
def share(turn: ti.template(), total: ti.i32):
    """The first item of the next share, and where it ends; the first is `total` when all are taken.

    Args:
        turn: (1,) an array of 0 at the start.
    """
    first, size = total, total // ti.static(_shares()) + 1
    if turn[0] < total:  # else it would grow without end
        first = ti.min(ti.atomic_add(turn[0], size), total)
    return first, ti.min(first + size, total)


@func
def after(n: ti.i32, stop: ti.i32, turn: ti.template(), total: ti.i32):
    """The item after n and where its share ends: of the next share where this one is done."""
    item, end = n + 1, stop
    if item == stop:
        item, end = share(turn, total)
    return item, end


def _shares() -> int:
    return SHARES if ti.lang.impl.current_cfg().arch in PROCESSORS else MANY
