"""The fourth law: a planted effect is fitted back, and named first or together with what looks alike."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from rich_view import rich_view, sensor_of
from scipy.optimize import least_squares
from scipy.special import digamma

from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

pytestmark = pytest.mark.slow

FRAMES = 100
FLOOR = 1e-5  # [m] below any spread of interest
# what the model already holds: 4 mm, enough to dither a Kinect's steps at 1 m, and more in the dark
KNOWN = AxialNoise(c0=0.004, shot=0.003, floor=0.003, ir_reference=1000.0)
# pixels err in step with each other, so the misfit counts them too often; the fitted value itself is held to 30 %
SHARED = ("lateral_noise", "pose_jitter")
ALIKE = 0.95  # cosine of two footprints


@dataclass(frozen=True)
class Seen:
    """Statistics of simulated frames, flattened, and how well each number is known."""

    mean: np.ndarray
    sigma: np.ndarray
    dropout: np.ndarray
    count: np.ndarray


@dataclass(frozen=True)
class Expectation:
    """What repeated frames of one view show.

    Attributes:
        mean: (h, w) of the depth [m].
        sigma: (h, w) its standard deviation [m].
        dropout: (h, w) missing share [1].
    """

    mean: np.ndarray
    sigma: np.ndarray
    dropout: np.ndarray


def expectation(sensor: Sensor, view: View) -> Expectation:
    """Mean, spread and missing share that a sensor gives of a view (its depth is the truth)."""
    if view.depth is None:
        raise ValueError("the view has no depth")
    depth = np.asarray(view.depth)
    return Expectation(*sensor.repeated(depth, view), sensor.dropout(depth, view))


def sensor_with(*effects: Effect) -> Sensor:
    """A sensor with a known noise and the effects; its noise follows the light where an effect changes the light."""
    if any(isinstance(effect, AxialNoise) for effect in effects):
        return sensor_of(*effects)
    return sensor_of(KNOWN, *effects)


def shown(kind: type[Effect]) -> View:
    """The rich view; light and shadow are computed, where the effect makes them."""
    return replace(rich_view(kind), ir=None if kind.changes("light") else rich_view(kind).ir, lit=None)


def watched(effect: Effect, view: View) -> Seen:
    sensor = sensor_with(effect)
    rng = np.random.default_rng(7)
    frames = np.array([sensor.sample(view.depth, view, None, rng) for _ in range(FRAMES)])
    count = np.isfinite(frames).sum(axis=0)
    with np.errstate(all="ignore"):
        mean = np.nansum(frames, axis=0) / count
        sigma = np.sqrt(np.nansum((frames - mean) ** 2, axis=0) / (count - 1))
    # a pixel with few values tells its missing share only
    few = count < FRAMES / 4
    return Seen(np.where(few, np.nan, mean), np.where(few, np.nan, sigma), 1 - count / FRAMES, count)


def whitened(seen: Seen, model: Expectation, weights: Expectation, view: View) -> np.ndarray:
    """(n,) differences in units of their standard deviations, three channels in a row; 0 where nothing is known."""
    freedom = np.maximum(seen.count - 1, 1)
    with np.errstate(all="ignore"):
        # the weights stay the same in a fit: a larger sigma must not buy a smaller misfit
        mean = (seen.mean - model.mean) / np.hypot(weights.sigma, FLOOR) * np.sqrt(seen.count)
        ratio = np.log((seen.sigma**2 + FLOOR**2) / (model.sigma**2 + FLOOR**2))
        # the logarithm of a sample variance: its mean and spread for normal noise
        sigma = np.where(seen.sigma > FLOOR, ratio - (digamma(freedom / 2) - np.log(freedom / 2)), ratio)
        sigma = sigma / np.sqrt(2 / freedom)
        p = np.clip(weights.dropout, 0.5 / FRAMES, 1 - 0.5 / FRAMES)
        dropout = (seen.dropout - model.dropout) / np.sqrt(p * (1 - p) / FRAMES)
    there = np.isfinite(view.depth)
    parts = np.concatenate([np.where(there, part, 0.0).ravel() for part in (mean, sigma, dropout)])
    return np.clip(np.where(np.isfinite(parts), parts, 0.0), -30, 30)


def planted_ones(kind: type[Effect]) -> list[tuple[Effect, list[str]]]:
    """The effect at typical values, one group of parameters at a time, with the names that are free in the fit."""
    about = parameters(kind).values()
    # how far neighbours share their noise is not in the statistics of single pixels
    usual = {p.name: p.typical for p in about if p.name != "correlation_px" or kind.frozen}
    out = []
    for group in dict.fromkeys(p.group for p in about):
        names = [p.name for p in about if p.group == group and p.name in usual]
        free = [p.name for p in about if p.name in names and p.typical != p.neutral]
        if free:
            out.append((kind(**{name: usual[name] for name in names}), free))
    return out


def model(effect: Effect, view: View) -> Expectation:
    return expectation(sensor_with(effect), view)


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_a_planted_value_is_fitted_back(kind):
    view = shown(kind)
    visible = 0
    for planted, free in planted_ones(kind):
        seen = watched(planted, view)
        for name in free:
            visible += _fitted_back(planted, name, seen, view)
    assert visible, "the view shows no parameter of this effect"


def _fitted_back(planted: Effect, name: str, seen: Seen, view: View) -> bool:
    """Fit one parameter, the others known; False when the view does not show it."""
    about = parameters(planted)[name]
    true = about.typical

    truth = model(planted, view)

    def misfit(value: float) -> np.ndarray:
        return whitened(seen, model(replace(planted, **{name: float(value)}), view), truth, view)

    def total(value: float) -> float:
        return float((misfit(value) ** 2).sum())

    if total(about.neutral) - total(true) < 25:  # five standard errors
        return False
    values = np.linspace(max(about.low, 0.3 * true), min(about.high, 3 * true), 19)
    start = min(values, key=total)
    fitted = least_squares(lambda x: misfit(x[0] * true), start / true, diff_step=1e-3).x[0] * true
    allowed = np.inf if planted.name in SHARED else 9
    # the misfit at the truth is above the lowest by at most 9, the square of three standard errors
    assert total(true) - min(total(fitted), total(start)) < allowed, f"{name}: {fitted}, not {true}"
    # one table angle shows one direction only, and two phases may fit it alike
    assert about.unit == "rad" or abs(fitted - true) < 0.3 * abs(true), f"{name}: {fitted}, not {true}"
    return True


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_a_planted_effect_is_named(kind):
    view = shown(kind)
    base = expectation(sensor_with(), view)
    visible = False
    rivals = [k for k in EFFECTS if not k.principles or view.camera.principle in k.principles]
    for planted, _ in planted_ones(kind):
        truth = model(planted, view)
        data = whitened(watched(planted, view), base, truth, view)
        footprints = {
            (rival.name, place): _direction(whitened(_exact(model(effect, view)), base, truth, view))
            for rival in rivals
            for place, (effect, _) in enumerate(planted_ones(rival))
        }
        gains = {name: abs(data @ direction) for name, direction in footprints.items()}
        named = max(gains, key=gains.__getitem__)
        own = max((name for name in gains if name[0] == kind.name), key=gains.__getitem__)
        if gains[own] < 5:
            continue
        visible = True
        assert named[0] == kind.name or abs(footprints[named] @ footprints[own]) > ALIKE, f"{named} instead of {own}"
    assert visible, "the view does not show this effect"


def _exact(expected: Expectation) -> Seen:
    """What infinitely many frames would show."""
    return Seen(expected.mean, expected.sigma, expected.dropout, np.full(expected.mean.shape, FRAMES))


def _direction(footprint: np.ndarray) -> np.ndarray:
    """Unit vector; nothing where the footprint is below five standard errors."""
    length = np.linalg.norm(footprint)
    return footprint / length if length > 5 else 0 * footprint
