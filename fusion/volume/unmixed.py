"""Frames without what is mixed sideways on the way from a surface to the volume.

A camera that matches windows gives a pixel the mean disparity of what its window sees of the pixel's surface, every
pixel is the mean over its square, and the volume takes half of it and half of its neighbours (`integration/planes.py`).
So what bulges is flattened, what is hollow filled, and rims, of which a window sees one side, come nearer. The surface
that was fused tells how much: as a frame sees it, and averaged so, it differs from itself by that. Whether the
camera's windows average is asked of the frames: as far as they stand beside the surface as it says, it is taken out.
Where they do, the surface is flattened itself and they stand too little beside it: they are asked once more beside
the one that comes of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F64, F64_2, kernel, ti
from fusion.compute.start import start
from fusion.progress import each
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import Prepared, fused
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
    """The window of a camera of focal length `fx` [px]; of a guessed width too, as the frames tell how it averages."""
    effect: Any = sensor.effect("edge_fattening")
    if effect is None or not np.any(effect.window_px):
        return MatchingWindow(NONE, None)
    return MatchingWindow(max(float(np.max(effect.window_px)), NONE), 1 / (fx * abs(sensor.baseline)))


def unmixed(
    frames: Sequence[Prepared | None], model: Volume, poses: Array, window: MatchingWindow
) -> list[Prepared | None]:
    """The frames at poses (n, 4, 4) without what is mixed sideways, as the model of all of them has it."""
    seen = _mixed(frames, model, poses, window)
    if seen.averages == 0:
        return seen.taken_from(frames, 0.0, window)
    sharper = fused(model.settings, seen.taken_from(frames, seen.averages, window), poses, "model")
    return seen.taken_from(frames, _mixed(frames, sharper, poses, window).averages, window)


@dataclass(frozen=True)
class _Mixed:
    """By how much the mean over a window lies above the model in each frame [1/m], and how much of it frames show."""

    bends: list[NDArray[np.float32] | None]
    averages: float  # 0-1

    def taken_from(
        self, frames: Sequence[Prepared | None], averages: float, window: MatchingWindow
    ) -> list[Prepared | None]:
        share = np.float32(averages + ALWAYS / window.variance)
        both = zip(frames, self.bends, strict=True)
        return [f if f is None or b is None else _without(f, share * b) for f, b in both]


def _mixed(frames: Sequence[Prepared | None], model: Volume, poses: Array, window: MatchingWindow) -> _Mixed:
    bends: list[NDArray[np.float32] | None] = []
    agreed, asked, near = 0.0, 0.0, model.settings.truncation
    for frame, T in zip(each(frames, "model"), poses, strict=True):
        bend = None
        if frame is not None and np.isfinite(T).all():
            inverse = 1 / model.raycast(frame.surface.camera, T).depth.astype(float)
            # what differs by more than a pixel does not match together
            apart = near * inverse**2 if window.one_px is None else np.full(inverse.shape, window.one_px)
            bend = flattened(inverse, window.width, apart)
            if window.one_px is not None:
                off = 1 / frame.depth - inverse
                use = np.abs(off) < apart
                weighted = frame.weight[use] * bend[use]
                agreed, asked = agreed + float(weighted @ off[use]), asked + float(weighted @ bend[use])
        bends.append(None if bend is None else bend.astype(np.float32))
    return _Mixed(bends, 0.0 if asked == 0 else float(np.clip(agreed / asked, 0, 1)))


def flattened(inverse: Array, width: float, apart: Array) -> Array:
    """By how much [1/m] the mean over a window of so many pixels lies above a surface (h, w) of one over depth [1/m],
    NaN where there is none; 0 there.

    Args:
        apart: (h, w) [1/m] what differs by more is another surface.
    """
    start()
    half = int(np.ceil((width - 1) / 2))
    share = np.ones(2 * half + 1)
    share[[0, -1]] = (width - 2 * half + 1) / 2  # what the window holds of its outermost pixels
    bend = np.zeros(inverse.shape)
    _flatten(inverse, apart, share, bend)
    return bend


@kernel
def _flatten(inverse: F64_2, apart: F64_2, share: F64, bend: F64_2):
    """As `flattened`; no comparison with NaN is true."""
    half = share.shape[0] // 2
    for v, u in ti.ndrange(inverse.shape[0], inverse.shape[1]):
        here, near = inverse[v, u], apart[v, u]
        total, count = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
        for j in range(ti.max(v - half, 0), ti.min(v + half + 1, inverse.shape[0])):
            for i in range(ti.max(u - half, 0), ti.min(u + half + 1, inverse.shape[1])):
                step = inverse[j, i] - here
                if ti.abs(step) < near:
                    one = share[j - v + half] * share[i - u + half]
                    total += one * step
                    count += one
        if count > 0:
            bend[v, u] = total / count


def _without(frame: Prepared, bend: NDArray[np.float32]) -> Prepared:
    """Normals and weights are kept: the change is second order."""
    depth = (1 / (1 / frame.depth - bend)).astype(np.float32)
    old = frame.surface
    stretch = np.where(np.isfinite(frame.depth), depth / frame.depth, 1)[..., None]
    return replace(frame, depth=depth, surface=replace(old, points=(old.points * stretch).astype(np.float32)))
