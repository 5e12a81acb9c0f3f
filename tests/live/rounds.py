"""A turn that is played round and round, as a camera before a table that does not stop; for tests."""

import threading
import time
from collections.abc import Iterator
from dataclasses import replace

from fusion.devices.source import Description, SourceFrame
from fusion.recording.recording import Recording


class Motor:
    """Notes how it was tilted."""

    def __init__(self) -> None:
        self.tilted: list[float] = []

    def tilt(self, degrees: float) -> None:
        self.tilted.append(degrees)


class Rounds:
    """`rate` frames a second of a recording of one turn until it is stopped, or `count`; with a motor to tilt."""

    def __init__(self, recording: Recording, rate: float, count: int = 10**9) -> None:
        self.camera, self.views, self.rate, self.count = recording.camera, list(recording), rate, count
        self.motor, self.stopped, self.given = Motor(), threading.Event(), 0

    def describe(self) -> Description:
        return Description("rounds", self.camera, rate=self.rate, color=True)

    def start(self) -> None:
        self.stopped.clear()

    def stop(self) -> None:
        self.stopped.set()

    def frames(self) -> Iterator[SourceFrame]:
        begin = time.monotonic()
        for index in range(self.count):
            due = index / self.rate
            if self.stopped.wait(max(0.0, begin + due - time.monotonic())):
                return
            view = replace(self.views[index % len(self.views)], index=index, timestamp=due)
            self.given += 1
            yield SourceFrame(**vars(view), device_time=due, host_time=time.time())

    def __enter__(self) -> "Rounds":
        self.start()
        return self

    def __exit__(self, *what: object) -> None:
        self.stop()
