"""A camera before a table that is turned step by step: one frame of each place, with the angle in its log."""

import math
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from types import TracebackType
from typing import Any, Protocol, Self

from fusion.devices.source import Description, Source, SourceFrame
from fusion.devices.table.command import Command
from fusion.devices.table.grbl import AXES, Grbl
from fusion.errors import DeviceError

STEP, SETTLE = 10.0, 0.5  # [deg], [s]: 37 views of a turn; what a plate swings after a step (guesses)
OLD = 2  # frames that a camera may still have had under way when the table came to rest (guess)


class Table(Protocol):
    """What turns."""

    def go(self, angle: float) -> float:
        """Turn to an angle [deg] from the start and wait until it stands; where it stands. Raises DeviceError."""

    def stop(self) -> None:
        """Stop turning; from any thread."""

    def close(self) -> None:
        """Let it go."""


def open_table(name: str) -> Table:
    """A table by what `--table` says: `grbl:PORT`, `grbl:PORT:AXIS`, or a command with `{angle}` or `{step}` in it.

    Raises:
        DeviceError: it is neither, or the table does not answer.
    """
    kind, _, rest = name.partition(":")
    if kind == "grbl" and rest:
        port, _, axis = rest.rpartition(":")
        return Grbl(port, axis.upper()) if port and axis and axis.upper() in AXES else Grbl(rest)
    if "{" in name or " " in name:
        return Command(name)
    raise DeviceError("there is no such table", "--table", name, 'grbl:PORT[:AXIS] or "command {angle}"')


class Stepped:
    """A source of one frame of each place of the table: step, settle, grab, step.

    Args:
        source: the camera, which runs on meanwhile; what it sends while the table turns is thrown away.
        step: [deg], its sign the direction.
        settle: [s] between the table's standing and the frame's beginning.
        count: of places; None: one turn, its first place again at the end.
    """

    def __init__(
        self, source: Source, table: Table, step: float = STEP, settle: float = SETTLE, count: int | None = None
    ) -> None:
        self.source, self.table, self.step = source, table, step
        self.count = math.ceil(round(360 / abs(step), 6)) + 1 if count is None else count
        about = source.describe()
        self._wait = settle + (OLD / about.rate if about.rate > 0 else 0.0)

    def describe(self) -> Description:
        """As the camera, but of so many frames; nobody knows how fast."""
        return replace(self.source.describe(), rate=0.0, length=self.count, stepped=True)

    @property
    def motor(self) -> Any:
        """What tilts the camera, or None."""
        return getattr(self.source, "motor", None)

    def start(self) -> None:
        """As the camera."""
        self.source.start()

    def frames(self) -> Iterator[SourceFrame]:
        """One frame of each place, `turntable_deg` in its log. Raises DeviceError: the camera's, or the table's."""
        with ThreadPoolExecutor(1, "fusion-table") as turning:
            try:
                stands, place = turning.submit(self._go, 0), 0
                for frame in self.source.frames():
                    angle = self._standing(stands, frame)
                    if angle is None:
                        continue
                    log = {**frame.log, "turntable_deg": angle}
                    yield replace(frame, index=place, log=log, missed=0)  # what was lost meanwhile was not wanted
                    place += 1
                    if place == self.count:
                        return
                    stands = turning.submit(self._go, place)
            finally:
                self.table.stop()

    def stop(self) -> None:
        """As the camera; the table stops too."""
        self.source.stop()
        self.table.stop()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()
        with suppress(OSError):
            self.table.close()

    def _go(self, place: int) -> tuple[float, float]:
        """Where the table stands [deg], and since when [s, of this machine's clock]."""
        return self.table.go(place * self.step), time.time()

    def _standing(self, stands: Future[tuple[float, float]], frame: SourceFrame) -> float | None:
        """The angle of a frame that began after the table had come to rest, or None."""
        if not stands.done():
            return None
        angle, since = stands.result()
        came = frame.host_time if math.isfinite(frame.host_time) else time.time()
        return angle if came >= since + self._wait else None
