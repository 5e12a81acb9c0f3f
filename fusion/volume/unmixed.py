"""Frames without what is mixed sideways on the way from a surface to the volume.

A camera that matches windows gives a pixel the mean disparity of what its window sees of the pixel's surface, every
pixel is the mean over its square, and the volume takes half of it and half of its neighbours (`integration/planes.py`).
So what bulges is flattened, what is hollow filled, and rims, of which a window sees one side, come nearer. The surface
that was fused tells how much: as a frame sees it, and averaged so, it differs from itself by that. Whether the
camera's windows average is asked of the frames: as far as they stand beside the surface as it says, it is taken out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.progress import each
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
ALWAYS = 0.25 + 1 / 12  # [px^2] variance along u and v of what the volume takes for a pixel, and of a pixel's square
NONE = 3.0  # [px] what tells how a surface bends where no window is matched: the least that has a middle


@dataclass(frozen=True)
class MatchingWindow:
    """What a camera matches."""

    width: float  # [px]
    one_px: float | None  # a step of the disparity by one pixel as one of 1 / depth [1/m]; None where none is matched

    @property
    def variance(self) -> float:
        """Along u and v [px^2], of a mean over whole pixels."""
        return (self.width**2 - 1) / 12


def matching_window(sensor: Sensor, fx: float) -> MatchingWindow:
    """The window of a camera of focal length `fx` [px]; one whose width is only guessed is none."""
    effect: Any = sensor.effect("edge_fattening")
    if effect is None or not sensor.std.get((effect.name, "window_px")):
        return MatchingWindow(NONE, None)
    return MatchingWindow(max(float(np.max(effect.window_px)), NONE), 1 / (fx * abs(sensor.baseline)))


def unmixed(
    frames: Sequence[Prepared | None], model: Volume, poses: Array, window: MatchingWindow
) -> list[Prepared | None]:
    """The frames at poses (n, 4, 4) without what is mixed sideways, as the model of all of them has it."""
    bends: list[Array | None] = []
    agreed, asked, near = 0.0, 0.0, model.settings.truncation
    for frame, T in zip(each(frames, "model"), poses, strict=True):
        bend = None
        if frame is not None and np.isfinite(T).all():
            inverse = 1 / model.raycast(frame.surface.camera, T).depth.astype(float)
            # what differs by more than a pixel does not match together
            apart = near * inverse**2 if window.one_px is None else np.full(inverse.shape, window.one_px)
            bend = flattened(inverse, window.width, apart)
            off = 1 / frame.depth - inverse
            use = np.abs(off) < apart
            weight = frame.weight[use].astype(float)
            agreed += float(np.sum(weight * off[use] * bend[use]))
            asked += float(np.sum(weight * bend[use] ** 2))
        bends.append(bend)
    averages = 0.0 if window.one_px is None or asked == 0 else float(np.clip(agreed / asked, 0, 1))
    share = averages + ALWAYS / window.variance
    return [f if f is None or b is None else _without(f, share * b) for f, b in zip(frames, bends, strict=True)]


def flattened(inverse: Array, width: float, apart: Array) -> Array:
    """By how much [1/m] the mean over a window of so many pixels lies above a surface (h, w) of one over depth [1/m],
    NaN where there is none; 0 there.

    Args:
        apart: (h, w) [1/m] what differs by more is another surface.
    """
    half = int(np.ceil((width - 1) / 2))
    share = np.ones(2 * half + 1)
    share[[0, -1]] = (width - 2 * half + 1) / 2  # what the window holds of its outermost pixels
    h, w = inverse.shape
    padded = np.pad(inverse, half, constant_values=np.nan)
    total, count = np.zeros((2, h, w))
    for a, b in np.ndindex(len(share), len(share)):
        step = padded[a : a + h, b : b + w] - inverse
        one = share[a] * share[b] * (np.abs(step) < apart)
        total += one * np.nan_to_num(step)
        count += one
    return np.asarray(total / np.maximum(count, 1e-12))


def _without(frame: Prepared, bend: Array) -> Prepared:
    """Normals and weights are kept: the change is second order."""
    depth = (1 / (1 / frame.depth - bend)).astype(np.float32)
    old = frame.surface
    stretch = np.where(np.isfinite(frame.depth), depth / frame.depth, 1)[..., None]
    return replace(frame, depth=depth, surface=replace(old, points=(old.points * stretch).astype(np.float32)))
