"""What an effect is planted with, and what comes of it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tools.trial.furnished.physics.bench import Bench, CameraRun
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.recorder import record
from tools.trial.furnished.physics.sensor import Effects, SensorNumbers


@dataclass(frozen=True)
class Soil:
    """Attributes:
    boost: scales the size.
    sign: -1 or 1, drawn before anything else.
    """

    rng: np.random.Generator
    bench: Bench
    recordings: list[CameraRun]
    boost: float
    sign: int

    @property
    def sensor(self) -> SensorNumbers:
        return self.bench.sensor

    @property
    def width(self) -> int:
        return self.bench.camera.width

    @property
    def height(self) -> int:
        return self.bench.camera.height

    def size(self, low: float, high: float) -> float:
        """Of either sign."""
        return self.sign * self.rng.uniform(low, high) * self.boost

    def positive(self, low: float, high: float) -> float:
        return self.rng.uniform(low, high) * self.boost

    def amplitudes(self) -> list[tuple[Array, Array]]:
        """(h, w) [counts] and whether something is seen: the first frame of each recording, without noise."""
        out = []
        for one in self.recordings:
            taken = record(self.bench, replace(one, times=one.times[:1]), {}, False)
            out.append((taken.amplitude[0], np.isfinite(taken.hits[0].z)))
        return out


@dataclass(frozen=True)
class Planted:
    """Attributes:
    effects: what the physics take.
    size: in words.
    variables: what it depends on, in words.
    also: other names that are right.
    channel: where it shows: "bias", "noise", "dropout" or "quant".
    without: effects that the sensor file must not tell.
    """

    effects: Effects
    size: str
    variables: str
    also: list[str] = field(default_factory=list)
    channel: str = "bias"
    without: frozenset[str] = frozenset()


Planter = Callable[[Soil], Planted]
