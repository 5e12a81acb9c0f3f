"""A source between camera and recorder that lets the view look on: the view gets what it can take, the recorder all."""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Self

from fusion.devices.source import Description, Source, SourceFrame

WAITING = 60  # frames that may wait for the view: what comes while the object is looked for (2 s at 30 a second)
FEW = 4  # once the view keeps up: what is shown is then no older (0.13 s at 30 a second)
PAUSED = 0.05  # [s] between two looks whether a pause is over
PATIENCE = 5.0  # [s] for a view to make up for steps that took long, such as a look for the object, before frames go


class Feed:
    """A source like the one it is made of, with a pause; the frames that are handed over are also offered to a view.

    While it is paused, frames are taken from the camera and thrown away, so that it runs on; a table that is turned
    step by step waits instead.

    Args:
        paused: begin with a pause.
        clock: [s] by which the view goes; another one than the machine's plays a busy or a quick one.
    """

    def __init__(self, source: Source, paused: bool = False, clock: Callable[[], float] = time.monotonic) -> None:
        self.source, self.paused, self.clock = source, paused, clock
        self.offered: deque[tuple[SourceFrame, float]] = deque()
        self.ready = threading.Condition()
        self.dropped = self.recorded = self.lost = 0
        self.over = False
        self._stopped = threading.Event()
        self.room = WAITING  # frames that may wait now
        self._late_since: float | None = None

    def describe(self) -> Description:
        """As the source."""
        return self.source.describe()

    def start(self) -> None:
        """As the source."""
        self._stopped.clear()
        self.source.start()

    def stop(self) -> None:
        """As the source."""
        self._stopped.set()
        self.source.stop()

    def frames(self) -> Iterator[SourceFrame]:
        """As the source, without those of a pause."""
        stepped = self.source.describe().stepped
        try:
            frames = self.source.frames()
            while not (stepped and self._halted()) and (frame := next(frames, None)) is not None:
                self.lost += frame.missed
                if self.paused and not stepped:
                    continue
                self.recorded += 1
                self.offer(frame, self.clock())
                yield frame
        finally:
            with self.ready:
                self.over = True
                self.ready.notify_all()

    def _halted(self) -> bool:
        """Wait while it is paused; whether it was stopped meanwhile."""
        while self.paused and not self._stopped.wait(PAUSED):
            pass
        return self._stopped.is_set()

    def take(self) -> tuple[SourceFrame, float] | None:
        """The oldest frame offered and when it came [s], waiting for it; None when none will come."""
        with self.ready:
            self.ready.wait_for(lambda: self.offered or self.over)
            return self.offered.popleft() if self.offered else None

    def offer(self, frame: SourceFrame, came: float) -> None:
        """Let the view have a frame that came then [s]; where too many wait for too long, the oldest go."""
        with self.ready:
            self.offered.append((frame, came))
            if len(self.offered) <= 1:  # it has caught up
                self._late_since = None
            elif len(self.offered) > self.room and self._late_since is None:
                self._late_since = came
            patient = self._late_since is not None and came - self._late_since < PATIENCE
            while len(self.offered) > (WAITING if patient else self.room):  # it goes on with the newer ones
                self.offered.popleft()
                self.dropped += 1
            self.ready.notify_all()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()
