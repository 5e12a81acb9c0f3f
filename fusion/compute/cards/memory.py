"""Kernels on a card: arrays are copied there before a call, and what a kernel may have written comes back after it.

Taichi would do so by itself, but on Vulkan what a kernel does not write would come back as whatever lay there before.
So a kernel gets arrays of the card. What is read only does not come back; what nobody can write to any more, such as
the rays of a camera, goes up once; and what is kept stays there, and comes back when it is fetched. Bytes are counted
both ways. On a processor nothing of this happens: kernels reach all memory, and arrays are what they are.
"""

from contextlib import ExitStack
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple, TypeVar
from weakref import ref

import numpy as np
from numpy.typing import NDArray

from fusion.compute.back_end import PROCESSORS, ti
from fusion.compute.spare import Spare

SMALL = 4096  # bytes up to which an array is not worth a place of its own
SPARE = 32  # unused arrays of the card that wait for arguments like those they were made for
CONSTANT = 64  # arrays that nobody can write to, of which copies stay there

AnyArray = TypeVar("AnyArray", bound=NDArray[Any])


@dataclass
class MovedBytes:
    """Bytes of arrays so far, to the card and from it."""

    up: int = 0
    down: int = 0


class Like(NamedTuple):
    """What an array of the card is made for."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]


class Newer(Enum):
    """Where an array that is kept was changed last."""

    HERE, NEITHER, THERE = range(3)


@dataclass
class KeptArray:
    """An array that stays on the card: the one that it stands for, and where it was changed last."""

    here: ref[NDArray[Any]]
    there: Any
    newer: Newer


moved = MovedBytes()
_kept: dict[int, KeptArray] = {}


def on_card() -> bool:
    """Whether what was started has memory of its own."""
    return ti.lang.impl.current_cfg().arch not in PROCESSORS


def keep(array: AnyArray) -> AnyArray:
    """The same array; on a card it stays there from its next kernel on."""
    if on_card() and array.size:
        key = id(array)
        _kept[key] = KeptArray(
            ref(array, lambda _: _kept.pop(key, None)), _made(Like(array.dtype, array.shape)), Newer.HERE
        )
    return array


def filled(shape: int | tuple[int, ...], value: float, dtype: type) -> NDArray[Any]:
    """An array of one value, that stays on a card until it is fetched; its values do not go there."""
    array: NDArray[Any] = keep(np.full(shape, value, dtype))
    if id(array) in _kept:
        _kept[id(array)].there.fill(value)
        _kept[id(array)].newer = Newer.NEITHER
    return array


def filled_in(shape: int | tuple[int, ...], dtype: type) -> NDArray[Any]:
    """An array that a kernel fills in, and that stays on a card until it is fetched."""
    array: NDArray[Any] = keep(np.empty(shape, dtype))
    if id(array) in _kept:
        _kept[id(array)].newer = Newer.NEITHER
    return array


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The same memory, for a kernel that only reads it: it need not come back from a card."""
    if not array.flags.writeable:
        return array
    view = array.view()
    view.flags.writeable = False
    return view


def fetch(array: AnyArray, changed: bool = False) -> AnyArray:
    """The same array as kernels left it; `changed` where it will be written to here."""
    kept = _kept.get(id(array))
    if kept is not None:
        if kept.newer is Newer.THERE:
            _take(kept.there, array)
            kept.newer = Newer.NEITHER
        if changed:
            kept.newer = Newer.HERE
    return array


def called(kernel: Any, args: tuple[Any, ...]) -> Any:
    """What a kernel gives, as the back end calls it, with its arrays on the card."""
    arrays = {n: a for n, a in enumerate(args) if type(a) is np.ndarray and a.size}
    given = {n: _stays(a) for n, a in arrays.items() if id(a) in _kept or _constant(a)}
    passing = {n: a for n, a in arrays.items() if n not in given}
    lent = {n: a for n, a in passing.items() if a.flags.writeable}
    moved.up += sum(a.nbytes for n, a in passing.items() if n not in lent)  # Taichi takes what is only read there
    with ExitStack() as stack:
        for n, a in lent.items():
            given[n] = stack.enter_context(_spare.taken(Like(a.dtype, a.shape)))
            _put(a, given[n])
        found = kernel(*[given.get(n, a) for n, a in enumerate(args)])
        for n, a in lent.items():
            _take(given[n], a)
    return found


def _stays(array: NDArray[Any]) -> Any:
    """The card's array of one that is kept or constant, as it is here if that is newer."""
    kept = _kept.get(id(array))
    if kept is None:
        keep(array)
        kept = _kept[id(array)]
        _forget_constants()
    if kept.newer is Newer.HERE:
        _put(array, kept.there)
    kept.newer = Newer.THERE if array.flags.writeable else Newer.NEITHER
    return kept.there


def _constant(array: NDArray[Any]) -> bool:
    """Whether nobody can write to an array any more."""
    base = array.base
    own = base is None or (type(base) is np.ndarray and base.base is None and not base.flags.writeable)
    return own and not array.flags.writeable and array.nbytes > SMALL


def _forget_constants() -> None:
    """The oldest of too many."""
    constant = [key for key, kept in _kept.items() if (a := kept.here()) is not None and not a.flags.writeable]
    for key in constant[:-CONSTANT]:
        del _kept[key]


def _made(like: Like) -> Any:
    return ti.ndarray(ti.lang.util.to_taichi_type(like.dtype), like.shape)


_spare: Spare[Like, Any] = Spare(_made, SPARE)


def _put(array: NDArray[Any], there: Any) -> None:
    there.from_numpy(np.ascontiguousarray(array))
    moved.up += array.nbytes


def _take(there: Any, array: NDArray[Any]) -> None:
    array[...] = there.to_numpy()
    moved.down += array.nbytes
