"""Kernels, called at a fifth of what Taichi's own calls cost.

Taichi 1.7 looks at every argument of every call as if it were the first: 9 us for an array, 2 us for a number, before
the kernel starts; a frame's kernels take 38 arrays to be fused and 79 to be seen. A kernel that was called before with
arguments of the same types is known to take them, and only has to be told where those lie that are others than at an
earlier call: 4 us for such an array, 1 us for one that is the same.

Several threads may call kernels, the same or others. Taichi would mix up two that it compiles at once: those wait for
each other. A launch keeps Python's lock from its begin to its end, as what Taichi runs loops on takes one at a time.
"""

import functools
import weakref
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from fusion.compute.taichi_copy import PROCESSORS, kernel_impl, reading, ti, turn

impl = kernel_impl.impl  # no import of Taichi beside the one that keeps it from greeting
Put = Callable[[Any, tuple[int], Any], None]
Given = list[Callable[[], Any]]  # the arrays of an earlier call, as long as they live


class Ready(NamedTuple):
    """A kernel compiled for arguments of some types, and how to hand over those that it gets at a call: which of the
    call's, as which of the kernel's, by what; and what earlier calls were made with, to be made with again."""

    program: Any
    kernel: Any
    compiled: Any
    puts: list[tuple[int, tuple[int], Put]]
    idle: list[tuple[Any, Given]]


class Kernel:
    """A kernel of ours, called as the function that it is made of.

    Attributes:
        plain: the same as Taichi calls it.
        ready: it compiled, by the types of its arguments; None for those that only Taichi can hand over.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        self.plain = kernel_impl.Kernel(function, kernel_impl.AutodiffMode.NONE)
        self.ready: dict[tuple[Any, ...], Ready | None] = {}
        functools.update_wrapper(self, function)

    def __call__(self, *args: Any) -> Any:
        types = _types(self.plain, args)
        ready = None if types is None else self.ready.get(types)
        if ready is None or ready.program is not impl.get_runtime().prog:
            return self._slowly(types, args)
        try:
            context, given = ready.idle.pop()
        except IndexError:  # the first call, or another thread is at one
            context, given = ready.kernel.make_launch_context(), [_nothing] * len(ready.puts)
        for m, (n, place, put) in enumerate(ready.puts):
            value = args[n]
            if put is not _array:
                put(context, place, value)
            elif given[m]() is not value:
                put(context, place, value)
                given[m] = weakref.ref(value)  # numpy moves no array that is referred to
        ready.program.launch_kernel(ready.compiled, context)
        ready.idle.append((context, given))
        return None

    def _slowly(self, types: tuple[Any, ...] | None, args: tuple[Any, ...]) -> Any:
        """As Taichi does it, after which it is known how to do the same again."""
        if ti.lang.impl.current_cfg().arch not in PROCESSORS and overlap(args):
            raise ValueError(
                f"{self.plain.func.__name__}: two arguments share memory; found on a card, which copies each"
            )
        with turn:
            with reading():
                found = self.plain(*args)
            program = impl.get_runtime().prog
            known = self.ready.get(types) if types is not None else None
            if types is not None and (known is None or known.program is not program):
                self.ready[types] = _ready(self.plain, args, program)
            return found


def kernel(function: Callable[..., None]) -> Kernel:
    """Marks a function as a kernel."""
    return Kernel(function)


def overlap(args: tuple[Any, ...]) -> bool:
    """Whether two arrays lie in the same memory: a card gets a copy of each, and what is written to one of them is lost
    when the other comes back."""
    ends = sorted(np.lib.array_utils.byte_bounds(a) for a in args if type(a) is np.ndarray and a.size)
    return any(begin < end for (_, end), (begin, _) in pairwise(ends))


def _nothing() -> None:
    """What is left of no array."""


def _types(kernel: Any, args: tuple[Any, ...]) -> tuple[Any, ...] | None:
    """What a compiled kernel depends on; None for a call that Taichi has to see itself."""
    if kernel.return_type is not None or kernel.autodiff_mode != kernel_impl.AutodiffMode.NONE:
        return None
    found: list[Any] = []
    for n, value in enumerate(args):
        if type(value) is np.ndarray and value.flags.c_contiguous:
            found.append((value.dtype, value.ndim))
        elif isinstance(value, (bool, int, float, np.number)):
            found.append((type(value), value if n in kernel.template_slot_locations else None))
        else:
            return None
    return tuple(found)


def _ready(kernel: Any, args: tuple[Any, ...], program: Any) -> Ready | None:
    """None where an argument is of a kind that is not handed over here, or on a device where nobody has tried it."""
    if program.config().arch not in PROCESSORS:
        return None
    given = [
        (n, a.annotation) for n, a in enumerate(kernel.arguments) if not isinstance(a.annotation, kernel_impl.template)
    ]
    puts = [(n, (place,), _put(annotation)) for place, (n, annotation) in enumerate(given)]
    known = [(n, place, put) for n, place, put in puts if put is not None]
    if len(known) < len(puts):
        return None
    compiled = kernel.compiled_kernels[kernel.ensure_compiled(*args)]
    data = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
    return Ready(program, compiled, data, known, [])


def _put(annotation: Any) -> Put | None:
    if isinstance(annotation, kernel_impl.ndarray_type.NdarrayType):
        return _array if id(annotation.dtype) in kernel_impl.primitive_types.type_ids else None
    return {id(ti.f32): _real, id(ti.f64): _real, id(ti.i32): _whole, id(ti.i64): _whole}.get(id(annotation))


def _array(context: Any, place: tuple[int], value: Any) -> None:
    context.set_arg_external_array_with_shape(place, value.ctypes.data, value.nbytes, value.shape, 0)


def _real(context: Any, place: tuple[int], value: Any) -> None:
    context.set_arg_float(place, float(value))


def _whole(context: Any, place: tuple[int], value: Any) -> None:
    context.set_arg_int(place, int(value))
