"""What a sensor model lets one observe, and how that changes with one effect: the footprint by which it is named."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View

STEP = 1e-3  # of a parameter's typical size: small against any curvature, large against rounding


@dataclass(frozen=True)
class Expectation:
    """What repeated frames of one view show.

    Attributes:
        mean: (h, w) of the depth [m].
        sigma: (h, w) its standard deviation [m].
        dropout: (h, w) missing share [1].
    """

    mean: Image
    sigma: Image
    dropout: Image

    def __sub__(self, other: "Expectation") -> "Expectation":
        return Expectation(self.mean - other.mean, self.sigma - other.sigma, self.dropout - other.dropout)

    def scaled(self, factor: float) -> "Expectation":
        """Every image times a number."""
        return Expectation(self.mean * factor, self.sigma * factor, self.dropout * factor)


def expectation(sensor: Sensor, view: View) -> Expectation:
    """Mean, spread and missing share that a sensor gives of a view (its depth is the truth)."""
    if view.depth is None:
        raise ValueError("the view has no depth")
    depth = np.asarray(view.depth)
    return Expectation(*sensor.repeated(depth, view), sensor.dropout(depth, view))


def contribution(sensor: Sensor, effect: Effect, view: View) -> Expectation:
    """How the expectation changes when the effect takes the place of the sensor's own of that name, or of none."""
    return expectation(sensor.having(effect), view) - expectation(sensor, view)


def signature(sensor: Sensor, effect: Effect, parameter: str, view: View) -> Expectation:
    """Derivative of the expectation in one parameter of an effect, per unit of the parameter; lists and maps as one.

    Two-sided inside the bounds, one-sided at a bound.
    """
    about = parameters(effect)[parameter]
    value = np.asarray(getattr(effect, parameter), float)
    h = STEP * (abs(about.typical) or 1.0)
    up, down = np.minimum(value + h, about.high), np.maximum(value - h, about.low)
    higher = expectation(sensor.having(_with(effect, parameter, up)), view)
    lower = expectation(sensor.having(_with(effect, parameter, down)), view)
    return (higher - lower).scaled(1.0 / float(np.max(up - down)))


def _with(effect: Effect, parameter: str, value: Any) -> Effect:
    return replace(effect, **{parameter: value if np.ndim(value) else float(value)})
