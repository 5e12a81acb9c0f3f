"""Where the object is, found while it turns and made larger as more of it shows."""

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.turntable.turning.moving import find_moving
from fusion.turntable.views import Region

BETWEEN = 0.25  # [s] between two frames that are compared: what turns has moved by then
FEWEST, MOST = 8, 24  # of them: `find_moving` takes from 6; more tell nothing new and cost time
MARGIN = 0.015  # [m] around what has moved, as around what turns in a whole recording
AGAIN = 2.0  # [s] between two looks once it was found
LONGEST = 40.0  # [s] after which all of it has shown (guess: the slowest common table takes that long for a turn)


class Looking:
    """Is shown depth images; knows the region of what turns once it has seen it turn."""

    def __init__(self, camera: Camera, sensor: Sensor) -> None:
        self.camera, self.sensor = camera, sensor
        self.region: Region | None = None
        self._samples: list[NDArray[np.float32]] = []
        self._first = self._last = self._looked = -np.inf

    def see(self, timestamp: float, depth: NDArray[np.float32]) -> None:
        """One frame [s, m]."""
        if timestamp - self._last < BETWEEN or (timestamp - self._first > LONGEST > 0 and np.isfinite(self._first)):
            return
        self._first = timestamp if not np.isfinite(self._first) else self._first
        self._last = timestamp
        self._samples.append(depth)
        if len(self._samples) > MOST:  # every second one goes, so that they still reach back to the first
            self._samples = self._samples[::2]
        if len(self._samples) >= FEWEST and (self.region is None or timestamp - self._looked > AGAIN):
            self._looked = timestamp
            self._look()

    def _look(self) -> None:
        try:
            found = find_moving(np.stack(self._samples), self.camera, self._sigma)
        except TrackingError:
            return
        self.region = Region(found.low, found.high, wall=found.wall).grown(MARGIN)

    def _sigma(self, z: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(self.sensor.sigma(z, None, self.camera), np.float32)
