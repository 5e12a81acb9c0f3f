"""Kernels, as they are called: by the back end, or quickly where that is known how to.

Several threads may call kernels, the same or others. A back end would mix up two that it compiles at once: those wait
for each other. A launch keeps Python's lock from its begin to its end, as what loops run on takes one at a time.
"""

import functools
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from fusion.compute.back_end import KNOWN, compiled, reading, turn
from fusion.compute.cards import memory
from fusion.compute.structures import apart, flattened, structures

if KNOWN:
    from fusion.compute.quick import Ready, made_ready, types_of


class Kernel:
    """A kernel of ours, called as the function that it is made of.

    Attributes:
        name: of that function.
        structured: whether structures are among its arguments.
        plain: the same as the back end calls it, with a structure's fields as arguments of their own.
        ready: it compiled, by the types of its arguments; None for those that only the back end can hand over; empty
            where no call is quick.
    """

    quick = KNOWN

    def __init__(self, function: Callable[..., None]) -> None:
        self.name = function.__name__
        self.structured = bool(structures(function))
        self.plain = compiled(flattened(function) if self.structured else function)
        self.ready: dict[tuple[Any, ...], Ready | None] = {}
        functools.update_wrapper(self, function)

    def __call__(self, *args: Any) -> Any:
        if self.structured:
            args = apart(args)
        types = types_of(self.plain, args) if self.quick else None
        ready = None if types is None else self.ready.get(types)
        if ready is None or not ready.runs():
            return self._slowly(types, args)
        return ready(args)

    def _slowly(self, types: tuple[Any, ...] | None, args: tuple[Any, ...]) -> Any:
        """As the back end does it, after which it is known how to do the same again."""
        there = memory.on_card()
        if there and overlap(args):
            raise ValueError(f"{self.name}: two arguments share memory; found on a card, which copies each")
        with turn:
            with reading():
                found = memory.called(self.plain, args) if there else self.plain(*args)
            known = self.ready.get(types) if types is not None else None
            if types is not None and (known is None or not known.runs()):
                self.ready[types] = made_ready(self.plain, args)
            return found


def kernel(function: Callable[..., None]) -> Kernel:
    """Marks a function as a kernel."""
    return Kernel(function)


def overlap(args: tuple[Any, ...]) -> bool:
    """Whether two arrays lie in the same memory: a card gets a copy of each, and what is written to one of them is lost
    when the other comes back."""
    ends = sorted(np.lib.array_utils.byte_bounds(a) for a in args if type(a) is np.ndarray and a.size)
    return any(begin < end for (_, end), (begin, _) in pairwise(ends))
