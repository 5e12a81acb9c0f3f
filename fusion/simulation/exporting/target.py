"""Target: another simulator's depth camera, its law of errors, and the parameters that it takes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

Floats = NDArray[np.floating]
Parameters = dict[str, float]


@dataclass(frozen=True)
class StatedWall:
    """What the own model says of a frontal wall, over the image, at several depths."""

    depths: Floats  # (n,) [m]
    at: Floats  # (n, walls) [m] where the walls around each depth stand
    # bias, sigma: (n, walls x pixels) [m] of the mean and of the spread of repeated frames, wall after wall; NaN where
    # nothing is measured
    bias: Floats
    sigma: Floats

    @property
    def mean_bias(self) -> Floats:
        """(n,) [m] over the image; NaN where nothing is measured."""
        return _mean(self.bias)

    @property
    def rms_sigma(self) -> Floats:
        """(n,) [m] over the image; NaN where nothing is measured."""
        return np.sqrt(_mean(self.sigma**2))


@dataclass(frozen=True)
class SimulatorTarget:
    """Another simulator."""

    name: str  # as `--to` takes it
    formula: str  # its law, one line
    source: str  # where it is published
    fit: Callable[[Sensor, Camera, StatedWall], Parameters]  # the parameters that come nearest to what a sensor states
    # (parameters, depth) to the mean error and the spread [m] of its law
    moments: Callable[[Parameters, Floats], tuple[Floats, Floats]]
    # (camera, parameters, comment lines) to the content of the file
    text: Callable[[Camera, Parameters, list[str]], str]
    carried: tuple[str, ...] = ()  # effects that its law knows, as far as its form allows
    own: str = ""  # errors that it makes besides, whatever is exported; "" none


def weighted(known: Floats, values: Floats, weights: Floats) -> float:
    """The factor k for which k * values comes nearest to `known` (n,), NaN left out; 0 where nothing is known."""
    good = np.isfinite(known) & np.isfinite(values) & (weights > 0)
    size = (weights * values**2)[good].sum()
    return float((weights * known * values)[good].sum() / size) if size > 0 else 0.0


def _mean(values: Floats) -> Floats:
    count = np.isfinite(values).sum(axis=1)
    total = np.nansum(values, axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
