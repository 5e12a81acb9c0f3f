"""How good each pixel of a corrected depth image is: its standard deviation, and its weight."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.sensor import SMALLEST_SIGMA, Sensor
from fusion.sensor.view import Image, View
from fusion.sensor.weights.edge_trust import doubtful

# share of its weight that a pixel keeps which may show another surface: it counts only where no better one looks, as
# at thin parts that are never seen but as an edge
DOUBT = 0.01


def sigma_of(sensor: Sensor, view: View) -> Image:
    """Standard deviation (h, w) [m] of the corrected depth in a view; NaN where it is missing.

    Args:
        view: with the corrected depth; the incidence, the amplitude and the moment as far as they are known.
    """
    return sigma_by_incidence(sensor, view)(view.incidence)


def sigma_by_incidence(sensor: Sensor, view: View) -> Callable[[Image | None], Image]:
    """`sigma_of` as a function of the incidence (h, w) [rad] or None, to be asked before it is known and again after.

    What the effects add that come before the first one to depend on it is computed once.
    """
    view = _completed(sensor, view)
    assert view.depth is not None
    first = next((n for n, e in enumerate(sensor.effects) if "incidence" in e.variables), len(sensor.effects))
    with np.errstate(invalid="ignore"):
        nothing = 0 * view.depth  # NaN where that is missing or infinite
    before = _spread(sensor.effects[:first], nothing, view)
    factor, after = view.noisier, sensor.effects[first:]
    if factor is not None:  # what the camera says of a pixel holds for tracking and fusion alike
        return lambda incidence: factor * _spread(after, before, replace(view, incidence=incidence))
    return lambda incidence: _spread(after, before, replace(view, incidence=incidence))


def _spread(effects: tuple[Effect, ...], sigma: Image, view: View) -> Image:
    assert view.depth is not None
    with np.errstate(all="ignore"):
        for effect in effects:
            sigma = effect.spread(sigma, view.depth, view)
    return np.asarray(sigma, np.float32)


def weight_of(sensor: Sensor, view: View, sigma: Image | None = None) -> Image:
    """(1 - dropout) / sigma^2 (h, w) [1/m^2]; 0 where the depth is missing, little where it may be another surface's.

    Args:
        view: as in `sigma_of`.
        sigma: what that gave, where it is known already.
    """
    sigma = sigma_of(sensor, view) if sigma is None else sigma
    view = _completed(sensor, view)
    assert view.depth is not None
    with np.errstate(all="ignore"):
        weight = (1 - sensor.doubt(view.depth, view)) / np.maximum(sigma, SMALLEST_SIGMA) ** 2
    doubt = doubtful(sensor, view.depth, view.time_of_flight)
    if doubt.any():
        weight = np.where(doubt, DOUBT * weight, weight)
    return np.asarray(np.fmax(weight, 0), np.float32)  # 0 of NaN


def _completed(sensor: Sensor, view: View) -> View:
    depth = np.asarray(view.depth, np.float32)
    return replace(view, depth=depth, baseline=sensor.baseline, principle=view.principle.or_else(sensor.principle))
