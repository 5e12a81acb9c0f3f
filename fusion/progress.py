"""How far long work has come and where its time went, told to whoever the caller chooses; nobody by default.

    with following(listener):
        scan = scan_turntable(recording)
        print(seconds())  # {"reading": 2.9, "motion": 8.7, ...}

Work tells its stages with `stage` and `each`. Stages may lie in one another: the outermost gets the time, the names of
all are shown. The listener is kept in a context variable and not passed as an argument: the loops that take the time
lie up to six calls below the public functions, and none between would do more than hand it on. Such a variable belongs
to one thread (and one asyncio task): two scans in two threads have a listener each, or none.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

Item = TypeVar("Item")
OTHER = "other"  # time that no stage claims


class Listener(Protocol):
    """Is told what happens; must return quickly."""

    def at(self, stages: tuple[str, ...], done: int, total: int | None) -> None:
        """In the last of `stages`, each inside the one before; `done` of `total` steps, None where nobody knows.

        No stage at all: what is printed now is not in the way.
        """

    def note(self, text: str) -> None:
        """Something that a person who waits should know."""


@dataclass(eq=False)
class _Stage:
    name: str
    total: int | None
    done: int = 0


@dataclass
class _Run:
    """What happens while one listener follows."""

    listener: Listener | None
    seconds: dict[str, float] = field(default_factory=dict)
    open: list[_Stage] = field(default_factory=list)
    since: float = field(default_factory=lambda: time.perf_counter())

    def enter(self, stage: _Stage) -> None:
        self.count()
        self.open.append(stage)
        self.tell()

    def leave(self, stage: _Stage) -> None:
        if stage in self.open:  # else one around it was left first, by an error
            self.count()
            del self.open[self.open.index(stage) :]
            self.tell()

    def count(self) -> None:
        """Give the time since the last change to whom it belongs."""
        now = time.perf_counter()
        name = self.open[0].name if self.open else OTHER
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self.since
        self.since = now

    def tell(self) -> None:
        if self.listener is not None:
            inner = self.open[-1] if self.open else _Stage("", None)
            self.listener.at(tuple(s.name for s in self.open), inner.done, inner.total)


_timeless = False
_run: ContextVar[_Run | None] = ContextVar("fusion.progress", default=None)


@contextmanager
def following(listener: Listener | None = None) -> Iterator[None]:
    """While the block runs, `listener` is told what happens, and `seconds` counts anew; None only counts."""
    token = _run.set(_Run(listener))
    try:
        yield
    finally:
        _run.reset(token)


@contextmanager
def stage(name: str, total: int | None = None) -> Iterator[Callable[[], None]]:
    """A part of the work, such as "tracking"; gives a function that is called after each of `total` steps."""
    run, entered = _run.get(), _Stage(name, total)

    def step() -> None:
        if run is not None:
            entered.done += 1
            run.tell()

    if run is None:
        yield step
        return
    run.enter(entered)
    try:
        yield step
    finally:
        run.leave(entered)


def each(items: Iterable[Item], name: str, total: int | None = None) -> Iterator[Item]:
    """The items, as a stage of which each is one step; `total` where the items do not know their number."""
    with stage(name, len(items) if isinstance(items, Sized) else total) as step:
        for item in items:
            yield item
            step()


def note(text: str) -> None:
    """Tell a person who waits something that is no part of the result."""
    run = _run.get()
    if run is not None and run.listener is not None:
        run.listener.note(text)


def leave_out_times() -> None:
    """From now on this process makes results that are the same bits whenever it makes them: without times and dates."""
    global _timeless
    _timeless = True


def timeless() -> bool:
    """Whether results hold no times and dates."""
    return _timeless


def seconds() -> dict[str, float]:
    """Time so far [s] of each outermost stage in the order of their start, "other" last; empty where nobody follows."""
    run = _run.get()
    if run is None or _timeless:
        return {}
    run.count()
    named = {name: value for name, value in run.seconds.items() if name != OTHER}
    return named | {OTHER: run.seconds.get(OTHER, 0.0)}
