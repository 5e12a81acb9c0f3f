"""What ends a run from outside: Ctrl-C, `kill`, a terminal that goes away. All end it alike: tidied up, in one line."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "the terminal went away"}


@dataclass
class Stop:
    """Which signal came first; 0 while none did."""

    number: int = 0

    @property
    def status(self) -> int:
        """The exit status, as a shell tells it."""
        return 128 + (self.number or signal.SIGINT)

    @property
    def words(self) -> str:
        return WORDS[signal.Signals(self.number or signal.SIGINT).name]


@contextmanager
def stoppable() -> Iterator[Stop]:
    """While the block runs, these signals raise KeyboardInterrupt in it; those that the caller ignores stay ignored."""
    stop = Stop()

    def arrived(number: int, frame: FrameType | None) -> None:
        again, stop.number = stop.number, stop.number or number
        if not again or number == signal.SIGINT:  # a second one would cut the tidying short; who means it presses again
            raise KeyboardInterrupt

    known = [signal.Signals[name] for name in WORDS if hasattr(signal, name)]
    before = {}
    try:
        if threading.current_thread() is threading.main_thread():  # no other may
            before = {number: signal.getsignal(number) for number in known}
            for number in known:
                if before[number] not in (signal.SIG_IGN, None):  # as nohup and background jobs ask for
                    signal.signal(number, arrived)
        yield stop
    finally:
        for number, handler in before.items():
            if handler is not None:
                signal.signal(number, handler)
