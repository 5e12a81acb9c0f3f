"""Progress of long work: a live bar on a terminal, a line now and then in a log, nothing for who wants quiet."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from fusion.progress import following

if TYPE_CHECKING:
    from tqdm import tqdm

DRAWN = 0.2  # [s] between two pictures of the bar
LOGGED = 5.0  # [s] between two lines in a log: shorter work leaves none
COUNTED = "{desc} {percentage:3.0f}%|{bar:30}| {n_fmt}/{total_fmt} [{elapsed}<{remaining}]{postfix}"
UNCOUNTED = "{desc} [{elapsed}]{postfix}"


@contextmanager
def showing(quiet: bool) -> Iterator[None]:
    """Show on stderr what the block's work tells (`fusion.progress`); its time per stage is counted in any case."""
    if quiet:
        with following(None):
            yield
        return
    shown: _Bar | _Log = _Bar() if sys.stderr.isatty() else _Log()
    done = threading.Event()
    # of its own: what computes for seconds without a step must look alive too
    clock = threading.Thread(target=_tick, args=(shown, done), daemon=True)
    clock.start()
    try:
        with following(shown):
            yield
    finally:
        done.set()
        clock.join()
        shown.close()


def _tick(shown: "_Bar | _Log", done: threading.Event) -> None:
    while not done.wait(DRAWN):
        shown.draw()


def took(seconds: dict[str, float]) -> str:
    """`26 s: reading 3, motion 9, ...`, what rounds to nothing left out."""
    whole = sum(seconds.values())
    digits = 0 if whole >= 10 else 1
    parts = [f"{name} {value:.{digits}f}" for name, value in seconds.items() if value >= 0.5 * 10**-digits]
    return f"{whole:.{digits}f} s: {', '.join(parts)}"


class _Bar:
    """The outermost stage as a bar, the inner ones behind it; one line, gone in the end."""

    def __init__(self) -> None:
        self.bar: tqdm[Any] | None = None
        self.lock = threading.Lock()

    def at(self, stages: tuple[str, ...], done: int, total: int | None) -> None:
        with self.lock:
            if not stages:
                self._end()
                return
            outer = self.bar
            if outer is None or outer.desc != stages[0] or (len(stages) == 1 and outer.total != total):
                self._begin(stages[0], total if len(stages) == 1 else None)
            if self.bar is not None:
                inner = "" if len(stages) == 1 else ": ".join([*stages[1:-1], _place(stages[-1], done, total)])
                self.bar.n = done if len(stages) == 1 else self.bar.n
                self.bar.set_postfix_str(inner, refresh=False)

    def _begin(self, name: str, total: int | None) -> None:
        from tqdm import tqdm

        self._end()
        self.bar = tqdm(total=total, leave=False, bar_format=COUNTED if total else UNCOUNTED, dynamic_ncols=True)
        self.bar.set_description_str(name)

    def note(self, text: str) -> None:
        from tqdm import tqdm

        tqdm.write(text, file=sys.stderr)

    def draw(self) -> None:
        with self.lock:
            if self.bar is not None:
                self.bar.refresh()

    def close(self) -> None:
        with self.lock:
            self._end()

    def _end(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None


class _Log:
    """A line every few seconds: how long it runs, and where it is."""

    def __init__(self) -> None:
        self.begin = self.last = time.monotonic()
        self.text, self.notes = "", ""

    def at(self, stages: tuple[str, ...], done: int, total: int | None) -> None:
        if stages:
            self.text = ": ".join([*stages[:-1], _place(stages[-1], done, total)])

    def note(self, text: str) -> None:
        self.notes += f"{text}\n"

    def draw(self) -> None:
        now = time.monotonic()
        if self.text and now - self.last >= LOGGED:
            sys.stderr.write(f"{self.notes}{now - self.begin:4.0f} s  {self.text}\n")
            sys.stderr.flush()
            self.last, self.notes = now, ""

    def close(self) -> None:
        """Nothing to tidy up."""


def _place(stage: str, done: int, total: int | None) -> str:
    return f"{stage} {done} of {total}" if total else stage
