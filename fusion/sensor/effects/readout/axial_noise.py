"""Axial noise: repeated depths of one pixel scatter, more so with distance, tilt and darkness."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect, independent, normal
from fusion.sensor.laws.fields import windowed
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

NGUYEN = "Nguyen, Izadi, Lovell 2012"
FANKHAUSER = "Fankhauser 2015, equations 1, 4 and 6"
TOF = "Lange and Seitz 2001: spread of a phase over the square root of the light"
# beyond this tilt the angle term is held: nobody fitted it beyond 75 deg, and it has a pole at 90 deg
STEEPEST = float(np.deg2rad(82.0))


@dataclass(frozen=True)
class AxialNoise(Effect):
    """A polynomial in z with terms of tilt and sunlight; where ir_reference and the amplitude are known, shot and floor
    take its place. The spread of the disparity joins either as independent noise.
    """

    name: ClassVar[str] = "axial_noise"
    key: ClassVar[str] = "N2, N3"
    formula: ClassVar[str] = (
        "sigma = c0 + c1 z + c2 z^2 + angle z^angle_exponent theta^2 / (pi/2 - theta)^2 + sunlight z^2 cos theta; "
        "with IR: sigma_range = sqrt(shot^2 q + floor^2 q^2), q = ir_reference / IR; "
        "sigma_z = sqrt(sigma^2 + (sigma_px z^2 / (fx b))^2)"
    )
    variables: ClassVar[tuple[str, ...]] = ("depth", "incidence", "amplitude")
    own: ClassVar[bool] = True

    c0: Value = parameter("m", (-1, 1), "constant term", f"{NGUYEN}; {FANKHAUSER}", "depth", typical=0.002)
    c1: Value = parameter("1", (-1, 1), "factor of z", f"{NGUYEN}; {FANKHAUSER}", "depth", typical=0.001)
    c2: Value = parameter("1/m", (-1, 1), "factor of z^2", f"{NGUYEN}; {FANKHAUSER}", "depth", typical=0.001)
    angle: Value = parameter(
        "m",
        (0, 0.1),
        "factor of theta^2 / (pi/2 - theta)^2 at z = 1 m",
        f"{NGUYEN}; {FANKHAUSER}",
        "angle",
        typical=0.0001,
    )
    angle_exponent: Value = parameter(
        "1",
        (-3, 3),
        "power of z in the angle term",
        f"-0.5 {NGUYEN}; 1.5 {FANKHAUSER}",
        "angle",
        typical=1.5,
        search=(-0.5, 0.0, 1.5, 2.0),  # as published, without, and as a disparity's noise grows
    )
    sunlight: Value = parameter(
        "1/m", (0, 1), "factor of z^2 cos(theta) in direct sun", FANKHAUSER, "sunlight", typical=0.002
    )
    shot: Value = parameter(
        "m", (0, 1), "spread from the light itself at ir_reference", TOF, "amplitude", typical=0.003
    )
    floor: Value = parameter(
        "m", (0, 1), "spread from the electronics at ir_reference", TOF, "amplitude", typical=0.003
    )
    ir_reference: Value = parameter(
        "count", (0, 1e6), "amplitude at which shot and floor are given", TOF, "amplitude", typical=1000.0
    )
    sigma_px: Value = parameter(
        "px", (0, 10), "spread of the disparity", "triangulation: d = fx b / z", "disparity", typical=0.05
    )
    correlation_px: Value = parameter(
        "px",
        (0, 50),
        "side of the window over which neighbours share their noise",
        "matching windows: simkinect",
        "disparity",
        typical=2.0,
    )

    def window(self, view: View) -> float:
        shared = np.any(self.sigma_px) and not view.time_of_flight
        return max(1.0, float(np.mean(self.correlation_px))) if shared else 1.0

    def noise(self, depth: Image, view: View) -> Image:
        sigma = self._shape(depth, view)
        if np.any(self.ir_reference) and view.ir is not None:
            ir = np.asarray(view.ir, depth.dtype)
            sigma = np.where(ir > 0, self._amplitude(ir, view), sigma)
        if np.any(self.sigma_px):
            in_depth = self._number("sigma_px", depth) / depth.dtype.type(view.focal_baseline) * depth**2
            sigma = independent(sigma, in_depth)
        return sigma

    def sampled(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        width = float(np.mean(self.correlation_px))
        white = windowed(rng, depth.shape, width) if width > 0 else normal(rng, depth)
        return depth + self.noise(depth, view) * white

    def _shape(self, z: Image, view: View) -> Image:
        """The polynomial with its angle and sunlight terms (h, w) [m]; 0 where it would be negative."""
        c0, c1, c2 = (self._number(name, z) for name in ("c0", "c1", "c2"))
        sigma = c0 + z * (c1 + c2 * z)
        tilted = view.incidence is not None and (np.any(self.angle) or np.any(self.sunlight))
        # a pixel of unknown tilt counts as frontal
        theta = np.zeros((), z.dtype)
        if tilted and view.incidence is not None:
            theta = np.minimum(np.fmax(np.asarray(view.incidence, z.dtype), 0), STEEPEST)
        if tilted and np.any(self.angle):
            tilt = theta / (z.dtype.type(np.pi / 2) - theta)
            sigma = sigma + self._number("angle", z) * _power(z, self._number("angle_exponent", z)) * (tilt * tilt)
        if np.any(self.sunlight):
            sigma = sigma + self._number("sunlight", z) * z**2 * np.cos(theta)
        return np.maximum(sigma, 0)

    def _amplitude(self, ir: Image, view: View) -> Image:
        """sqrt(shot^2 q + floor^2 q^2) of the radial distance, q = ir_reference / IR, as depth (h, w) [m]."""
        q = self._number("ir_reference", ir) / np.maximum(ir, 1e-9)
        return np.sqrt(q * (self._number("shot", ir) ** 2 + self._number("floor", ir) ** 2 * q)) / view.stretch

    def _number(self, name: str, like: Image) -> Image:
        return np.asarray(getattr(self, name), like.dtype)


def _power(z: Image, exponent: Image) -> Image:
    """z ** exponent (h, w), anything where z is missing; by roots where they do, a fifth of the time."""
    whole, rest = divmod(float(exponent), 1.0) if exponent.ndim == 0 else (0.0, -1.0)
    if rest in (0.0, 0.5):
        return np.asarray(z ** int(whole) * (np.sqrt(z) if rest else 1))
    # powers of NaN take six times as long
    return np.asarray(np.where(z > 0, z, 1) ** exponent)
