"""Ambient light: sun and lamps add shot noise to time of flight, and drown the pattern of triangulation."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# Time of flight. Shot noise of E lux over the signal: sigma ~ sqrt(reflectance E) / (reflectance cos / range^2).
# Beyond FILLS the wells would be full, exposures get shorter and the signal with them: sigma ~ E.
FILLED_BY = 1000.0  # [lux] guess: room light does not shorten an exposure, daylight does
# Added noise at 1 m, so that indoor and added noise make Fankhauser's law in the sun (90 klx) at 0.7 to 1.9 m, and his
# overcast law at 1 m in its middle light of 6 klx; that law grows less with distance, and is met at 1 to 2.8 m by
# 2.25 klx (the light was 1 to 12 klx)
SIGMA_1M, SIGMA_LUX, SIGMA_REFLECTANCE = 0.0024, 6000.0, 0.8
# Overcast light comes from everywhere; what exceeds it comes from the sun, in Fankhauser's setting from behind the
# camera, and fades with cos(incidence). Other suns are nearer to their brightest than to none: the same is taken.
DIFFUSE_LUX = 15_000.0
# Added noise beyond which a phase is refused: 73 % valid at 1 m and 45 deg in 90 klx, none at 2.8 m (Fankhauser,
# table II); the sharpness is a guess between that and all valid under clouds
REFUSED, SHARPNESS = 0.03386, 4
# Triangulation: light that equals the pattern's at 1 m, which spreads with z^2, and doubles the variance: all guesses
EQUAL_LUX, SIGMA_PX, LOST_AT = 30_000.0, 0.08, 2.0


@dataclass(frozen=True)
class AmbientLight(Effect):
    """Noise and dropout of light beyond `view.moment.ambient`, for which the other laws of the sensor hold."""

    name: ClassVar[str] = "ambient_light"
    key: ClassVar[str] = "N12"
    formula: ClassVar[str] = (
        "itof: sigma_range = 2.4 mm range^2 sqrt(g(E) / g(6 klx)) / sqrt(reflectance / 0.8), "
        "g = E (1 + E / 1 klx), what exceeds 15 klx times cos(incidence); "
        "P(missing) = 1 - exp(-(sigma_range / 34 mm)^4); "
        "triangulation: sigma_disparity = 0.08 px sqrt(E z^2 / 30 klx), P(missing) = 1 - exp(-(E z^2 / 60 klx)^4)"
    )
    variables: ClassVar[tuple[str, ...]] = ("ambient", "range", "incidence", "reflectance")

    ambient: Value = parameter(
        "lux",
        (0, 150_000),
        "light at the surface beyond that of the moment",
        "shot noise; coefficients from Fankhauser 2015 and guesses",
        typical=1000.0,
    )

    noise_share: Value = parameter(
        "1",
        (0, 1),
        "share of the noise that is added; 0 where the sensor's own noise law was measured in this light",
        "definition",
        neutral=1.0,
    )

    def noise(self, depth: Image, view: View) -> Image:
        if not np.any(self.ambient) or not np.any(self.noise_share):
            return np.zeros((), depth.dtype)
        return self.noise_share * added_noise(view.moment.ambient, self.ambient, depth, view)

    def dropout(self, depth: Image, view: View) -> Image:
        if not np.any(self.ambient):
            return np.zeros((), depth.dtype)
        before, after = view.moment.ambient, view.moment.ambient + self.ambient
        if view.time_of_flight:
            # the fourth power of the noise; sigma ~ sqrt(shot), so that is linear in the square of the light
            scale = np.square(np.square(_at_one_shot(depth, view) / REFUSED))
            return _at_rate(scale * (np.square(_shot(after, depth, view)) - np.square(_shot(before, depth, view))))
        drowned = depth**2 * (1.0 / (EQUAL_LUX * LOST_AT))
        return _at_rate(np.square(np.square(drowned)) * (after**4 - before**4))

    def loses_with(self, depth: Image, view: View) -> Image | None:
        """Other light over that of a pattern, which spreads; how many values that costs is a guess in `dropout`."""
        return None if view.time_of_flight else depth**2


def _at_rate(x: Image) -> Image:
    """1 - exp(-x) (h, w): a tenth of the time of numpy's `expm1`, which would be exact for chances below 1e-4."""
    return np.asarray(1 - np.exp(-x))


def added_noise(before: float, more: Value, depth: Image, view: View) -> Image:
    """Noise (h, w) [m] that comes with `more` lux beyond `before` lux."""
    if view.time_of_flight:
        root = np.sqrt(_shot(before + more, depth, view) - _shot(before, depth, view))
        return _at_one_shot(depth, view) / view.stretch * root
    root = np.sqrt(more / EQUAL_LUX)
    return np.asarray(SIGMA_PX / view.focal_baseline * root, depth.dtype) * depth**3


def _shot(lux: Value, depth: Image, view: View) -> Image:
    """Variance of the range that light adds, 1 at SIGMA_LUX; the direct part of the light fades with cos(incidence)."""
    direct = np.asarray(np.maximum(lux - DIFFUSE_LUX, 0.0), depth.dtype)
    if view.incidence is not None and np.any(direct):
        # an unknown incidence is frontal
        direct = direct * np.cos(np.nan_to_num(np.asarray(view.incidence, depth.dtype)))
    falling = np.asarray(np.minimum(lux, DIFFUSE_LUX), depth.dtype) + direct
    return falling * (1.0 + falling / FILLED_BY) / (SIGMA_LUX * (1.0 + SIGMA_LUX / FILLED_BY))


def _at_one_shot(depth: Image, view: View) -> Image:
    """Standard deviation of the range (h, w) [m] at SIGMA_LUX; what is not known is as bright as usual.

    It does not depend on the incidence: in Fankhauser's laws the noise up to 45 deg is that of a frontal surface.
    """
    sigma = SIGMA_1M * (depth * view.stretch) ** 2
    if view.reflectance is not None:
        seen = np.nan_to_num(np.asarray(view.reflectance, depth.dtype), nan=SIGMA_REFLECTANCE)
        sigma = sigma * np.sqrt(SIGMA_REFLECTANCE / np.maximum(seen, 0.01))
    return sigma
