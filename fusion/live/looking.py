"""Where the object is, found while it turns and made larger as more of it shows."""

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.turntable.turning.moving import find_moving
from fusion.turntable.views import Region

BETWEEN = 0.1  # [s] between two frames that are compared
FEWEST, MOST = 8, 24  # of them: `find_moving` takes from 6; more tell nothing new and cost time
MARGIN = 0.015  # [m] around what has moved, as around what turns in a whole recording
AGAIN = 1.5  # it is looked again when so many times as many were shown: a look takes half a second (measured)
LONGEST = 60.0  # [s] after which all of it has shown (guess: a slow table takes so long for a turn)


class Looking:
    """Is shown depth images; knows the region of what turns once it has seen it turn."""

    def __init__(self, camera: Camera, sensor: Sensor) -> None:
        self.camera, self.sensor = camera, sensor
        self.region: Region | None = None
        self._samples: list[NDArray[np.float32]] = []
        self._first: float | None = None
        self._last, self._count, self._next = -np.inf, 0, FEWEST

    def see(self, now: float, depth: NDArray[np.float32]) -> None:
        """One frame: when it came [s] and its depth [m]."""
        self._first = now if self._first is None else self._first
        if now - self._last < BETWEEN or (self.region is not None and now - self._first > LONGEST):
            return
        self._last = now
        self._samples.append(depth)
        self._count += 1
        if len(self._samples) > MOST:  # every second one goes, so that they still reach back to the first
            self._samples = self._samples[::2]
        if self._count >= self._next:
            self._next = int(np.ceil(AGAIN * self._count))
            self._look()

    def _look(self) -> None:
        try:
            found = find_moving(np.stack(self._samples), self.camera, self._sigma)
        except TrackingError:
            return
        self.region = Region(found.low, found.high, wall=found.wall).grown(MARGIN)

    def _sigma(self, z: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(self.sensor.sigma(z, None, self.camera), np.float32)
