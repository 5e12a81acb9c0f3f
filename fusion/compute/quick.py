"""How a kernel that Taichi 1.7 compiled is called at a fifth of what Taichi's own call costs.

Taichi looks at every argument of every call as if it were the first: 9 us for an array, 2 us for a number, before the
kernel starts; a frame's kernels take 38 arrays to be fused and 79 to be seen. A kernel that was called before with
arguments of the same types is known to take them, and only has to be told where those lie that are others than at an
earlier call: 4 us for such an array, 1 us for one that is the same.
"""

import weakref
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fusion.compute.back_end import PROCESSORS, ti
from fusion.compute.back_ends.taichi_copy import kernel_impl

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

    def runs(self) -> bool:
        """Whether what it was compiled for still runs: Taichi may be started anew."""
        return self.program is impl.get_runtime().prog

    def __call__(self, args: tuple[Any, ...]) -> None:
        try:
            context, given = self.idle.pop()
        except IndexError:  # the first call, or another thread is at one
            context, given = self.kernel.make_launch_context(), [_nothing] * len(self.puts)
        for m, (n, place, put) in enumerate(self.puts):
            value = args[n]
            if put is not _array:
                put(context, place, value)
            elif given[m]() is not value:
                put(context, place, value)
                given[m] = weakref.ref(value)  # numpy moves no array that is referred to
        self.program.launch_kernel(self.compiled, context)
        self.idle.append((context, given))


def _nothing() -> None:
    """What is left of no array."""


def types_of(kernel: Any, args: tuple[Any, ...]) -> tuple[Any, ...] | None:
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


def made_ready(kernel: Any, args: tuple[Any, ...]) -> Ready | None:
    """None where an argument is of a kind that is not handed over here, or on a device where nobody has tried it."""
    program = impl.get_runtime().prog
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
