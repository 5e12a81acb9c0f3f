"""One case: a sensor in a world, with what has been cast kept for its frames."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tools.trial.furnished.physics.lens import StatedCamera, directions
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import SensorNumbers
from tools.trial.furnished.physics.world import SeenPixels, World
from tools.trial.furnished.rooms.parts import ScenePart

Key = tuple[Any, ...] | None


@dataclass
class CameraRun:
    """Attributes:
    index: of the recording.
    times: (frames,) [s].
    stated: pose that is told, by time.
    static: whether the camera stands still.
    true: pose where the camera is, by time and by the frame's time.
    """

    index: int
    times: Array
    stated: Callable[[float], Array]
    static: bool
    true: Callable[[float, float], Array] = field(repr=False, default=lambda time, frame: np.eye(4))


@dataclass(frozen=True)
class Instant:
    """A frame that is taken.

    Attributes:
        recording, frame: indices.
        time: [s].
        pose: (4, 4), or (h, 4, 4) one for each row.
        path: pose by time, for samples beside the frame's time.
        key: under which casts are kept, None for never.
        moving: whether the camera moves.
    """

    recording: int
    frame: int
    time: float
    pose: Array
    path: Callable[[float], Array]
    key: Key
    moving: bool


@dataclass
class Bench:
    """Attributes:
    camera: as stated.
    world: what is truly there; `parts` of it.
    ambient, rise, settling: [degC, K, s] the sensor's temperature starts at `ambient` and rises by `rise`.
    zero: [degC] at which the sensor does not drift.
    """

    sensor: SensorNumbers
    camera: StatedCamera
    world: World
    parts: list[ScenePart]
    seed: int
    ambient: float
    rise: float
    settling: float
    zero: float
    casts: dict[Any, Any] = field(default_factory=dict)
    _rays: dict[Any, Array] = field(default_factory=dict)

    def directions(self, camera: StatedCamera, du: float = 0.0, dv: float = 0.0) -> Array:
        key = (camera, du, dv)
        if key not in self._rays:
            self._rays[key] = directions(camera, du, dv)
        return self._rays[key]

    def cast(self, T: Array, camera: StatedCamera, du: float = 0.0, dv: float = 0.0, key: Key = None) -> SeenPixels:
        """What the camera sees from `T` (4, 4) or (h, 4, 4)."""
        if key is None:
            return self.world.cast(T, self.directions(camera, du, dv))
        whole = (key, du, dv, camera)
        if whole not in self.casts:
            self.casts[whole] = self.world.cast(T, self.directions(camera, du, dv))
        return self.casts[whole]

    def warmth(self, time: float) -> float:
        """[K] above the temperature without drift."""
        return self.temperature(time) - self.zero

    def temperature(self, time: float) -> float:
        """[degC]"""
        return self.ambient + self.rise * (1 - np.exp(-time / self.settling))
