"""Depth quantisation: depths come in steps, of length or of disparity."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect, independent
from fusion.sensor.laws.disparity import disparity
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

CALM = 0.25  # of a step: noise that reaches no second edge; what is beyond it is eight standard deviations away
WAVES = 5  # of a saw-tooth behind more noise: the sixth is 1e-19 of a step
FADED = 1e-17  # of a wave: rounding


@dataclass(frozen=True)
class DepthQuantization(Effect):
    """Rounding of d = fx b / z to multiples of step_px, then of z to multiples of step."""

    name: ClassVar[str] = "depth_quantization"
    key: ClassVar[str] = "N1"
    formula: ClassVar[str] = "d_measured = step_px round(d / step_px); z_measured = step round(z / step)"
    variables: ClassVar[tuple[str, ...]] = ("depth",)
    not_corrected: ClassVar[str] = "rounding loses what it rounds off; it counts as noise of step / sqrt(12)"
    frozen: ClassVar[str] = "depth"
    lattice: ClassVar[dict[str, str]] = {"constant": "step", "z^2": "step_px"}

    step: Value = parameter(
        "m", (0, 0.1), "smallest difference of two depths", "sensor's number format", "length", typical=0.001
    )
    step_px: Value = parameter(
        "px",
        (0, 2),
        "smallest difference of two disparities",
        "1/8 px: github ankurhanda/simkinect",
        "disparity",
        typical=0.125,
    )

    def bias(self, depth: Image, view: View) -> Image:
        rounded = depth
        step, step_px = np.asarray(self.step, depth.dtype), np.asarray(self.step_px, depth.dtype)
        if np.any(step_px):
            # a depth so large that its disparity rounds to 0 is held at one step
            whole = np.maximum(np.round(disparity(depth, view) / step_px), 1)
            rounded = depth.dtype.type(view.focal_baseline) / (whole * step_px)
        if np.any(step):
            rounded = np.round(rounded / step) * step
        return rounded - depth

    def noise(self, depth: Image, view: View) -> Image:
        step, step_px = np.asarray(self.step, depth.dtype), np.asarray(self.step_px, depth.dtype)
        if not np.any(step_px):
            return step / 12**0.5
        in_depth = step_px / depth.dtype.type(view.focal_baseline) * depth**2
        return independent(in_depth, step) / 12**0.5

    def repeated(self, mean: Image, sigma: Image, view: View) -> tuple[Image, Image]:
        """Noise in front of the rounding makes its mean smooth: exact for normal noise."""
        if np.any(self.step_px):
            slope = view.focal_baseline / mean**2  # px of disparity per m
            d, spread = rounded(view.focal_baseline / mean / self.step_px, sigma * slope / self.step_px)
            mean = view.focal_baseline / (np.maximum(d, 1) * self.step_px)
            sigma = spread * self.step_px / slope
        if np.any(self.step):
            z, spread = rounded(mean / self.step, sigma / self.step)
            mean, sigma = z * self.step, spread * self.step
        return mean, sigma


def rounded(mean: Image, sigma: Image) -> tuple[Image, Image]:
    """Mean and standard deviation of round(x) for normal x."""
    x, wide = np.broadcast_arrays(mean, sigma)
    base, calm = np.round(x), wide < CALM
    off, spread = x - base, np.empty_like(wide)
    for some, law in ((calm, _by_tails), (~calm, _by_waves)):
        off[some], spread[some] = law(off[some], wide[some])
    return base + off, spread


def _by_tails(x: Image, sigma: Image) -> tuple[Image, Image]:
    """The same of x within half a step of 0, by the shares that lie beyond the nearest edges: noise is small."""
    from scipy.special import ndtr

    sigma = np.maximum(sigma, 1e-6)
    first, second = np.zeros_like(x), np.zeros_like(x)
    for side in (-1, 1):
        near, far = (ndtr((side * x - edge) / sigma) for edge in (0.5, 1.5))
        first += side * (near + far)
        second += near + 3 * far
    return first, np.sqrt(np.maximum(second - first**2, 0.0))


def _by_waves(x: Image, sigma: Image) -> tuple[Image, Image]:
    """The same by the series of the saw-tooth round(x) - x, whose waves noise fades (Widrow and Kollar, 2008)."""
    sine, cosine = -np.sin(2 * np.pi * x), -np.cos(2 * np.pi * x)
    s, c, fades = sine, cosine, np.exp(-2 * (np.pi * sigma) ** 2)
    faded, step = fades, fades**2
    bias, square, wide = np.zeros_like(x), sigma**2 + 1 / 12, 4 * sigma**2
    for k in range(1, WAVES + 1):
        bias += faded * s / (np.pi * k)
        square += faded * c * (wide + 1 / (np.pi * k) ** 2)
        s, c, fades = s * cosine + c * sine, c * cosine - s * sine, fades * step
        faded = faded * fades
        if not np.any(faded > FADED):
            break
    return x + bias, np.sqrt(np.maximum(square - bias**2, 0.0))
