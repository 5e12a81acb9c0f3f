"""Structured light below the level of depth: dots of a pattern, each read beside its place, matched in windows.

Four places per pixel make an image of twice the resolution. A dot of the projector's pattern lies there where the
surface sends it; its place is read with an error that stays as long as nothing moves (speckle) and one of each frame.
A window's disparity is the mean over its dots on one surface, the nearer one if that has enough of the window; it is
rounded to 1/8 px of the full resolution. What goes wrong: the device's own product of focal length and baseline, a
shift of all disparities, a smooth warp of the pattern over the image, small steps at some columns.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, uniform_filter

from tools.sets.fresh.flight import stated
from tools.sets.fresh.lens import Lens
from tools.sets.fresh.views import NOTHING, Scene

Array = NDArray[np.float64]

WINDOW = 10  # px of the full resolution, as is the next
STEP = 0.125
SURFACE = 1.5  # [px] disparities of one surface differ by less within a window
DOTS = 0.12  # of the places of the pattern hold one
ENOUGH = 0.4  # share of a window's dots on the nearer surface that makes it win


@dataclass(frozen=True)
class Dots:
    """A unit; px of disparity are those of the recording (half the full resolution).

    Attributes:
        baseline: from the camera to the projector on its left [m].
        constant: the device's focal length times baseline, over the true one.
        shift: (h, w) [px] that is added to the disparity.
        pattern: (2 h, period) whether there is a dot; `speckle`: (2 h, period) [full px] what it is read beside.
        noise: [full px] of one dot in one frame.
    """

    lens: Lens
    baseline: float
    constant: float
    shift: Array
    pattern: NDArray[np.bool_]
    speckle: float
    noise: float
    principle = "structured_light"
    counts_per_metre = 5000

    def frames(
        self, scene: Scene, count: int, rng: np.random.Generator, rays: list[Array], ideal: bool = False
    ) -> tuple[Array, None]:
        """Depth (n, h, w) [m], 0 where invalid; no amplitude."""
        views = [scene.look(r) for r in rays]
        window = _about(np.any([v.part != NOTHING for v in views], axis=0))
        near = _woven([v.z[window] for v in views])
        seen = _woven([v.part[window].astype(float) for v in views]) != NOTHING
        fb = self.lens.fx * self.baseline
        with np.errstate(divide="ignore"):
            true = np.where(seen, 2 * fb / near, 0.0)  # full px
        seen &= ~shaded(true)
        v, u = np.indices(true.shape)
        pattern = self.pattern[2 * window[0].start : 2 * window[0].stop]
        place = v, np.rint(u + 2 * window[1].start + true).astype(int) % pattern.shape[1]
        dot = seen & pattern[place]
        frozen = (self.speckle * rng.standard_normal(pattern.shape))[place]
        front = dot & (true > maximum_filter(true * seen, WINDOW) - SURFACE)
        back, share = dot & ~front, _window(dot)
        wins, many = _window(front) > ENOUGH * np.maximum(share, 1e-9), [_window(front), _window(back)]
        lost = (share * WINDOW**2 < 2.5) | (_window(seen) < 0.5)
        out = np.zeros((count, *rays[0].shape[:2]))
        for i in range(count):
            read = true + frozen + (self.noise * rng.standard_normal(pattern.shape))[place]
            some = [
                _window(np.where(k, read, 0)) / np.maximum(n, 1e-9) for k, n in zip((front, back), many, strict=True)
            ]
            d = np.where(wins, *some) / 2 + (0.0 if ideal else self.shift[window])
            d = np.round(2 * d / STEP) * STEP / 2
            z = fb * (1.0 if ideal else self.constant) / np.maximum(d, STEP)
            out[i][window] = np.where(lost | (z > 8.0) | (z < 0.35), 0.0, z)
        return out, None

    def depth_std(self, z: Array) -> Array:
        """Standard deviation [m] of one pixel's depth in one frame, speckle included."""
        one = np.hypot(np.hypot(self.noise, self.speckle) / np.sqrt(DOTS * WINDOW**2), STEP / np.sqrt(12)) / 2
        return np.asarray(one * z**2 / (self.lens.fx * self.baseline))

    def sensor(self, rng: np.random.Generator) -> list[dict[str, Any]]:
        """What its owner knows of it: window, noise, rounding, where the projector is."""
        dots = 2 * np.sqrt(DOTS * WINDOW**2)
        off = 1 + 0.08 * rng.standard_normal(2)
        speckle, noise = self.speckle / dots * off[0], self.noise / dots * off[1]
        wide = (WINDOW / 2, "px", 0.5)
        return [
            stated("projector_shadow", baseline=(-0.075, "m", 0.0004)),
            stated("edge_fattening", window_px=wide),
            stated("speckle_noise", sigma_px=(speckle, "px", 0.15 * speckle), correlation_px=wide),
            stated("axial_noise", sigma_px=(noise, "px", 0.1 * noise), correlation_px=wide),
            stated("depth_quantization", step_px=(STEP / 2, "px", 0)),
        ]


def shaded(disparity: Array) -> NDArray[np.bool_]:
    """Where the projector on the left does not shine: a nearer surface already holds that column of its pattern."""
    column = np.arange(disparity.shape[1]) + disparity
    return np.asarray(column < np.maximum.accumulate(column, axis=1) - 1.0)


def _woven(parts: list[Array]) -> Array:
    """Four images as one of twice the resolution."""
    h, w = parts[0].shape
    return np.asarray(np.array(parts).reshape(2, 2, h, w).transpose(2, 0, 3, 1).reshape(2 * h, 2 * w))


def _about(seen: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Rows and columns where anything is seen, with a margin."""
    out = []
    for axis in (1, 0):
        at = np.flatnonzero(seen.any(axis=axis))
        low, high = (int(at[0]), int(at[-1])) if len(at) else (0, 0)
        out.append(slice(max(low - WINDOW, 0), min(high + WINDOW, seen.shape[1 - axis])))
    return out[0], out[1]


def _window(image: NDArray[Any]) -> Array:
    """(h, w) means over the windows about the centres of the recording's pixels; of a full-size image."""
    return np.asarray(uniform_filter(image.astype(float), WINDOW, mode="constant")[1::2, 1::2])


def drawn(rng: np.random.Generator, lens: Lens) -> Dots:
    """A unit with a lens."""
    v, u = np.mgrid[: lens.height, : lens.width].astype(float)
    shift = np.full(u.shape, rng.uniform(-0.08, 0.08))
    for _ in range(4):  # a smooth warp, some waves over the image
        a, b = rng.uniform(-1.3, 1.3, 2)
        wave = np.cos(2 * np.pi * (a * u / lens.width + b * v / lens.height) + rng.uniform(0, 2 * np.pi))
        shift += 0.03 * rng.standard_normal() * wave
    x, y = (u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy
    shift += 0.08 * np.clip(rng.standard_normal(), -2, 2) * (x**2 + y**2)
    for column in rng.uniform(0, lens.width, 5):
        shift += 0.015 * rng.standard_normal() * (u > column)
    pattern = rng.random((2 * lens.height, 2 * lens.width)) < DOTS
    constant = 1 + 0.004 * np.clip(rng.standard_normal(), -2, 2)
    speckle, noise = rng.uniform(0.12, 0.18), rng.uniform(0.15, 0.22)
    return Dots(lens, 0.075 + 0.0002 * rng.standard_normal(), constant, shift, pattern, speckle, noise)
