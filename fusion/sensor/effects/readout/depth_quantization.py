"""Depth quantisation: depths come in steps, of length or of disparity."""

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect, independent
from fusion.sensor.laws.disparity import disparity
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


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
    """Mean and standard deviation of round(x) for normal x; beyond sigma = 1 rounding is only more noise."""
    x, wide = (np.array(a, copy=True) for a in np.broadcast_arrays(mean, sigma))
    spread = np.sqrt(wide**2 + np.asarray(1 / 12, wide.dtype))
    fine = wide <= 1.0
    x[fine], spread[fine] = _rounded_finely(x[fine], np.maximum(wide[fine], 1e-6))
    return x, spread


def _rounded_finely(mean: Image, sigma: Image) -> tuple[Image, Image]:
    """The same by the shares of the values that are near."""
    from scipy.special import ndtr

    base = np.round(mean)
    reach = np.arange(-4, 5)
    below = [ndtr((k - 0.5 - (mean - base)) / sigma) for k in (*reach, reach[-1] + 1)]
    shares = [high - low for low, high in pairwise(below)]
    first = sum(k * share for k, share in zip(reach, shares, strict=True))
    second = sum(k * k * share for k, share in zip(reach, shares, strict=True))
    return base + first, np.sqrt(np.maximum(second - np.square(first), 0.0))
