"""How bright it was, from the noise itself: what Fankhauser 2015 left open."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.light_law import MOST_LUX, ROOM_LUX, LightLaw, light_law
from fusion.calibration.noise.poses import Pose
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

LEVEL = 0.9
# how far noise may be off a law, as a share: at one place, in `SCATTER` steps, and of a whole unit, when the law is one
# of its kind or of this very unit: guesses, from Fankhauser's 0.55 mm rms under clouds and 4.4 mm in the sun
SCATTER = np.geomspace(0.01, 0.3, 8)
UNIT, OWN_UNIT = 0.05, 0.01
UNIT_STEPS = np.linspace(-2.0, 2.0, 9)  # standard deviations
LIGHTS = np.concatenate([[ROOM_LUX], np.geomspace(400.0, MOST_LUX, 240)])  # [lux]
DROWNED = 0.9  # with fewer valid values than this the light shows in them too
SHARE_STD = 0.15  # of a share of missing values by the law: it depends on brightness and thresholds, a guess
NOT_DARK = 1.353  # half a chi2 of one number, 10 %: less is no sign of light

Array = NDArray[np.floating]


@dataclass(frozen=True)
class LightPoint:
    """Noise at one place: depth [m], tilt [rad], standard deviation of one depth [m] and how well it is known; `valid`:
    share of pixels with a value. `sigma` may be NaN where nothing is measured any more."""

    depth: float
    tilt: float
    sigma: float
    sigma_std: float
    valid: float = 1.0


@dataclass(frozen=True)
class AmbientEstimate:
    """Ambient light at the surface."""

    lux: float  # estimate [lux]
    # low, high: 90 % interval [lux]; low is 0 where the noise is not above that of a room, high is inf where it is
    # beyond the brightest law
    low: float
    high: float
    # noise_low, noise_high: the same were the light of the laws known exactly: what the noise alone says
    noise_low: float
    noise_high: float
    points: int  # places that were used
    law: str  # where the noise over light comes from
    sentence: str  # for a person


def points_of(poses: Iterable[Pose]) -> list[LightPoint]:
    """Poses of a target as places with noise."""
    return [LightPoint(p.depth, p.tilt, p.axial, p.axial_std, p.seen.valid) for p in poses]


def estimate_ambient(
    points: Sequence[LightPoint], camera: Camera, sensor: Sensor | None = None
) -> AmbientEstimate | None:
    """Ambient light from noise at known distance and tilt; None when no noise law of this sensor is known.

    Args:
        points: with rounding and other known noise taken out; more points make the interval honest about the law.
        camera: tells the kind of sensor.
        sensor: its noise without ambient light, best calibrated for this unit.
    """
    law = light_law(sensor, camera)
    usable = [p for p in points if np.isfinite([p.depth, p.tilt]).all() and p.depth > 0]
    usable = [p for p in usable if _has_noise(p) or p.valid < DROWNED]
    if law is None or not usable:
        return None
    log = _log_likelihood(usable, law)
    weight = np.exp(log - np.max(log)) * np.gradient(LIGHTS) / (LIGHTS + ROOM_LUX)
    weight /= weight.sum()
    readings = law.readings(LIGHTS)
    lux = _quantile(LIGHTS, weight, 0.5)
    noise_low, noise_high = (_quantile(LIGHTS, weight, 0.5 + side * LEVEL / 2) for side in (-1, 1))
    all_weights = np.broadcast_to(weight / len(readings), readings.shape)
    low, high = (_quantile(readings.ravel(), all_weights.ravel(), 0.5 + side * LEVEL / 2) for side in (-1, 1))
    if np.max(log) - log[0] < NOT_DARK:
        low = noise_low = 0.0
    # the brightest light is as likely as the best: nothing bounds it from above
    if np.max(log) - log[-1] < NOT_DARK:
        high = noise_high = float("inf")
    sentence = _sentence(lux, low, high, len(usable))
    return AmbientEstimate(lux, low, high, noise_low, noise_high, len(usable), law.text, sentence)


def _log_likelihood(points: list[LightPoint], law: LightLaw) -> Array:
    """(m,) of the nominal lights, over all scatters and unit errors."""
    depth, tilt = np.array([p.depth for p in points]), np.array([p.tilt for p in points])
    noisy = np.array([_has_noise(p) for p in points])
    variance = law.variance(depth, tilt, LIGHTS)
    total = np.zeros(len(LIGHTS))
    if noisy.any():
        sigma = np.array([p.sigma for p in points])[noisy]
        share = np.maximum(np.array([p.sigma_std for p in points])[noisy] / sigma, 1e-3)
        total += _of_noise(sigma, share, np.sqrt(variance[:, noisy]), law.own)
    drowned = np.array([p.valid < DROWNED for p in points])
    if drowned.any():
        lost = 1.0 - np.array([p.valid for p in points])[drowned]
        law_lost = np.array([law.missing(depth[drowned], tilt[drowned], lux) for lux in LIGHTS])
        total += -0.5 * (((lost - law_lost) / SHARE_STD) ** 2).sum(axis=1)
    return total


def _of_noise(sigma: Array, share: Array, predicted: Array, own: bool) -> Array:
    """(m,) log likelihood of measured noise (n,) at predicted (m, n), scatter and unit error summed over."""
    off = np.log(sigma / predicted)
    unit = OWN_UNIT if own else UNIT
    parts = []
    for scatter in SCATTER:
        deviation = np.hypot(share, scatter)
        for step in UNIT_STEPS:
            z = (off - step * unit) / deviation
            parts.append(-0.5 * (z**2).sum(axis=1) - np.log(deviation).sum() - 0.5 * step**2)
    stack = np.array(parts)
    top = np.max(stack, axis=0)
    return np.asarray(top + np.log(np.exp(stack - top).sum(axis=0)))


def _has_noise(point: LightPoint) -> bool:
    return bool(np.isfinite([point.sigma, point.sigma_std]).all() and point.sigma > 0 and point.sigma_std > 0)


def _quantile(values: Array, weights: Array, share: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(np.interp(share, total - 0.5 * weights[order], values[order]))


def _sentence(lux: float, low: float, high: float, points: int) -> str:
    where = f"from the noise at {points} place{'s' if points > 1 else ''}"
    if low <= 0 and np.isinf(high):
        return f"the noise says nothing about the ambient light ({where})"
    if low <= 0:
        return f"ambient light below {_klx(high)} {where}: no more noise than in a room"
    if np.isinf(high):
        return f"ambient light above {_klx(low)} {where}"
    return f"ambient light of about {_klx(lux)} ({_klx(low)} to {_klx(high)}, 90 % interval) {where}"


def _klx(lux: float) -> str:
    return f"{lux / 1000:.2g} klx" if lux < 10_000 else f"{lux / 1000:.0f} klx"
