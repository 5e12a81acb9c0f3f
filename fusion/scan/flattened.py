"""What windows, pixels and the volume's planes flatten, given back by the model of all frames.

A matching window tells the mean of one over the depth of what it holds, a pixel that of its square; on a surface that
bulges towards the camera the mean lies behind the surface, by side^2 / 24 times the sum of both curvatures: 0.4 mm on
a body of 7 cm radius before windows of 15 mm. It is no noise: it makes what is round too thin from all sides. The
model of all frames is smooth, so the same mean over what the model shows says how much is missing, and that is added to
what was measured (Van Cittert 1931, one step), smoothed. Planes that are fused touch the surface at
a mean of five pixels (see `volume/integration/planes`) and are read within half a pixel of there: a twelfth of the
second differences is missing too, for what is fused alone.

Windows that hold an edge of the model are left as they are: what they match there is no mean.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.relief import STEEP
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
PLANES = 1 / 12  # of the second differences: 1/8 by the mean of five pixels less 1/24 by the planes read between them
# windows over which what is given back is smoothed: of detail finer than that the model shows noise, and rings at folds
# (measured on the statue of the open challenges, true poses: std 0.25 mm before, 0.48 mm without, 0.29 mm with 2.6)
SMOOTH = 2.6


@dataclass(frozen=True)
class Flattening:
    """What is to be added (h, w) [m] to the depth that was `measured`, and to that which is `fused`; 0 at edges."""

    measured: Array
    fused: Array


def flattening(depth: NDArray[np.floating], side: float, steep: float) -> Flattening:
    """What means over squares make of a surface.

    Args:
        depth: (h, w) of the surface itself [m], NaN where there is none.
        side: of the squares [px], 1 or more.
        steep: a depth that changes by more than so many times itself from pixel to pixel is an edge.
    """
    z = np.asarray(depth, float)
    with np.errstate(invalid="ignore", divide="ignore"):
        inverse = np.nan_to_num(1 / z, posinf=0.0)
        smooth = np.isfinite(z)
        for axis in (0, 1):
            step = ~(np.abs(np.diff(z, axis=axis)) < steep * np.take(z, range(z.shape[axis] - 1), axis))
            before, after = ((0, 1), (1, 0))
            pads = [[(0, 0), (0, 0)], [(0, 0), (0, 0)]]
            pads[0][axis], pads[1][axis] = before, after
            smooth &= ~np.pad(step, pads[0], constant_values=True) & ~np.pad(step, pads[1], constant_values=True)
    weights = box(side)
    around = np.ones((len(weights), len(weights)), np.uint8)
    whole = cv2.erode(smooth.astype(np.uint8), around, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    mean = cv2.sepFilter2D(inverse, -1, weights, weights) - inverse
    bend = cv2.Laplacian(inverse, cv2.CV_64F, ksize=1)
    square = np.where(whole, z, 0.0) ** 2
    return Flattening(*(_smoothed(square * x, whole, side) for x in (mean, mean + PLANES * bend)))


def _smoothed(image: Array, known: NDArray[np.bool_], side: float) -> Array:
    """The mean over the known pixels around each of them; 0 at the others."""
    weights = box(SMOOTH * side)
    there = np.where(known, 1.0, 0.0)
    total, count = (cv2.sepFilter2D(x, -1, weights, weights) for x in (there * image, there))
    return np.asarray(np.where(known, total / np.maximum(count, 1e-9), 0.0))


def box(side: float) -> Array:
    """Weights (odd,) of a mean over `side` pixels; of a single pixel those with the same spread as its square."""
    spread = max(side, 1.0) ** 2 / 12  # px^2
    half = max(int(np.ceil((side - 1) / 2 - 1e-9)), 1)
    at = np.arange(-half, half + 1)
    inner = np.where(np.abs(at) < half, 1.0, 0.0)
    # the two outer weights w make the spread right: (sum of inner k^2 + 2 w half^2) / (inner + 2 w) = spread
    outer = (spread * inner.sum() - np.sum(inner * at**2)) / (2 * (half**2 - spread))
    weights = np.where(np.abs(at) < half, 1.0, outer)
    return np.asarray(weights / weights.sum())


def unflattened(
    frames: list[Prepared | None], poses: Array, settings: VolumeSettings, side: float
) -> list[Prepared | None]:
    """The frames as they would be without windows, by the model that they make at poses (n, 4, 4)."""
    return given_back(frames, flattenings(frames, poses, settings, side))


def flattenings(
    frames: list[Prepared | None], poses: Array, settings: VolumeSettings, side: float
) -> list[Flattening | None]:
    """What the frames lack, by the model that they make at poses (n, 4, 4); None for those that take no part."""
    volume = Volume(settings)
    for frame, T in zip(frames, poses, strict=True):
        if frame is not None and np.isfinite(T).all():
            fuse(volume, frame, T)
    return [
        None if frame is None or not np.isfinite(T).all() else _lost(frame, volume, T, side)
        for frame, T in zip(frames, poses, strict=True)
    ]


def given_back(frames: list[Prepared | None], lost: list[Flattening | None]) -> list[Prepared | None]:
    """The frames with what was flattened added."""
    return [
        frame if frame is None or what is None else _with(frame, what) for frame, what in zip(frames, lost, strict=True)
    ]


def _lost(frame: Prepared, volume: Volume, T: Array, side: float) -> Flattening:
    """Of what lies on the model; the rest is not what it shows."""
    camera, reach = frame.surface.camera, volume.settings.truncation
    model = volume.raycast(camera, T).depth
    found = flattening(model, side, STEEP / camera.fx)
    with np.errstate(invalid="ignore"):
        here = np.abs(frame.surface.points[..., 2] - model) < reach
    return Flattening(*(np.where(here, np.clip(x, -reach, reach), 0.0) for x in (found.measured, found.fused)))


def _with(frame: Prepared, lost: Flattening) -> Prepared:
    points = frame.surface.points
    with np.errstate(invalid="ignore"):
        stretched = points * (1 + lost.measured / points[..., 2])[..., None]
    surface = replace(frame.surface, points=stretched.astype(np.float32))
    return replace(frame, depth=(frame.depth + lost.fused).astype(np.float32), surface=surface)
