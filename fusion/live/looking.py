"""Where the object is, found while it turns and made larger as more of it shows."""

from concurrent.futures import Executor, Future
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.turntable.turning.moving import Moving, find_moving
from fusion.turntable.views import Region

BETWEEN = 0.1  # [s] between two frames that are compared
FEWEST, MOST = 8, 24  # of them: `find_moving` takes from 6; more tell nothing new and cost time
# pixels of the images that are compared, at least: of 640 a look takes half a second; of 160 it lost the upper half of
# an object to noise (measured)
ACROSS = 320
MARGIN = 0.015  # [m] around what has moved, as around what turns in a whole recording: of mixed pixels
AGAIN = 1.5  # it is looked again when so many times as many were shown: a look takes half a second (measured)
PUT_OFF = 2.0  # times as many frames where the view is late, and what turns is known (a guess)
SURE = 2  # looks that must have found it before a model begins: the first may know a part, and later frames miss that
SOON = 4  # more frames to the second look once the first has found it (a guess)
ALL = 600  # compared after which all of it has shown (guess: a minute, which a slow table takes for a turn)


class Looking:
    """Is shown depth images; knows the region of what turns once it has seen it turn.

    Attributes:
        region: what turns, or None.
        finds: looks that found it.
        beside: where looks are taken, so that who shows the images need not wait for them; None: at once.
    """

    def __init__(self, camera: Camera, sensor: Sensor) -> None:
        self.camera, self.sensor, self._step = camera, sensor, max(1, camera.width // ACROSS)
        self._small = every(camera, self._step)
        self.region: Region | None = None
        self.finds = 0
        self.beside: Executor | None = None
        self._under_way: Future[Moving | None] | None = None
        self._samples: list[NDArray[np.float32]] = []
        self._last, self._count, self._next = -np.inf, 0, FEWEST

    def see(self, now: float, depth: NDArray[np.float32], late: bool = False) -> None:
        """One frame: when it came [s] and its depth [m]; while the view is late, a look that adds little can wait."""
        if self._under_way is not None and self._under_way.done():
            self._learn(self._under_way.result())  # what went wrong there is told here
            self._under_way = None
        if now - self._last < BETWEEN or (self.region is not None and self._count >= ALL):
            return
        self._last = now
        self._samples.append(depth[:: self._step, :: self._step])
        self._count += 1
        if len(self._samples) > MOST:  # every second one goes, so that they still reach back to the first
            self._samples = self._samples[::2]
        due = PUT_OFF * self._next if late and self.finds >= SURE else self._next
        if self._count < due or self._under_way is not None:
            return
        self._next = int(np.ceil(AGAIN * self._count))
        asked = np.stack(self._samples), self._small, self.sensor
        if self.beside is None:
            self._learn(look(*asked))
        else:
            self._under_way = self.beside.submit(look, *asked)

    def _learn(self, found: Moving | None) -> None:
        if found is None:
            return
        (height, width), step = self.camera.shape, self._step
        wall = found.wall.repeat(step, axis=0).repeat(step, axis=1)[:height, :width]
        self.region = Region(found.low, found.high, wall=wall).grown(MARGIN)
        self.finds += 1
        if self.finds == 1:
            self._next = min(self._next, self._count + SOON)


def look(samples: NDArray[np.float32], camera: Camera, sensor: Sensor) -> Moving | None:
    """What turns in a sample (k, h, w) of the frames [m]; None where nothing does."""
    try:
        return find_moving(samples, camera, lambda z: np.asarray(sensor.sigma(z, None, camera), np.float32))
    except TrackingError:
        return None


def every(camera: Camera, step: int) -> Camera:
    """The camera that has one of `step` pixels, each way, from the first on."""
    width, height = -(-camera.width // step), -(-camera.height // step)
    fx, fy, cx, cy = (value / step for value in (camera.fx, camera.fy, camera.cx, camera.cy))
    return replace(camera, width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy, color=None)
