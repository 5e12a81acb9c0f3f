"""Ctrl-C and its like as a flag that a loop looks at: nothing is raised, so nothing can be lost or cut in two.

An exception that a handler raises comes between any two steps of Python: in a callback it is dropped, and between a
lock and its block it leaves the lock taken, so that the thread that writes waits for ever (seen: a recording that did
not end).
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")


class ByHand:
    """`asked` once a person, or who stands for one, wants it to end."""

    def __init__(self) -> None:
        self.asked = False
        self._again: Callable[[], Any] = lambda: None

    def pass_on(self) -> None:
        """Let the signal do what it would have done without the block."""
        self._again()


@contextmanager
def by_hand() -> Iterator[ByHand]:
    """While the block runs, the first of these signals only sets the flag; a second Ctrl-C does what it did before.

    Signals that are ignored, or end the process by the system's own way, stay so; in a thread other than the main one
    nothing is changed, as Python hands signals to the main one alone.
    """
    made = ByHand()
    before: dict[int, Callable[[int, FrameType | None], Any]] = {}

    def arrived(number: int, frame: FrameType | None) -> None:
        if made.asked and number == signal.SIGINT:
            before[number](number, frame)
        elif not made.asked:
            made.asked, made._again = True, lambda: before[number](number, None)

    try:
        if threading.current_thread() is threading.main_thread():
            for known in [signal.Signals[name] for name in NAMES if hasattr(signal, name)]:
                handler = signal.getsignal(known)
                if callable(handler):  # else ignored, or the system's
                    before[known] = handler
                    signal.signal(known, arrived)
        yield made
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
