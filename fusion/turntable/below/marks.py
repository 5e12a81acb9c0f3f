"""Marks on what is seen from above: what differs from its surroundings, and does not stand still."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.recording.ahead import ahead
from fusion.turntable.below.ground import Ground, Image

Array = NDArray[np.float64]
MOST = 100  # marks of a view, the clearest
CLEAR = 0.03  # `contrastThreshold`: a mark differs by a tenth from its surroundings, noise by a hundredth (guess)
EDGE = 6  # `edgeThreshold`: borders and folds of a sheet are no marks
FULL = 0.5  # contrast that is as bright as a pixel can be
LOOKS = 4  # orientations that one mark may have
INSIDE = 9  # [px] square around a mark that has to be seen
FIRST = 6  # frames that tell whether there are marks at all
FEWEST = 4  # marks that show a motion


@dataclass(frozen=True)
class Marks:
    """The marks of one view."""

    at: Array  # (k, 2) places from the middle of the square [m], along `across()`
    looks: Image  # (k, LOOKS, 128) unit vectors that describe them, zero where there are fewer
    bright: NDArray[np.bool_]  # (k,) brighter than around them
    shown: NDArray[np.bool_]  # (side, side) where the ground is seen


@dataclass(frozen=True)
class Marked:
    """The ground, and its marks in some of the frames."""

    ground: Ground
    marks: dict[int, Marks]  # by frame


def marked(
    ground: Ground, camera: Camera, frames: list[int], depths: NDArray[np.float32], colors: NDArray[np.uint8]
) -> Marked | None:
    """The marks of a ground that turns; None where nothing on it moves.

    Args:
        ground: which.
        camera: of the frames.
        frames: k numbers.
        depths: (k, h, w) [m].
        colors: (k, h, w, 3) of the same pixels, black where unknown.
    """
    some = np.unique(np.linspace(0, len(frames) - 1, FIRST).round().astype(int))
    few = _marks(ground, ground.seen(camera, depths[some], colors[some]))
    if np.median([len(m.at) for m in few]) < FEWEST:
        return None
    return Marked(ground, dict(zip(frames, _marks(ground, ground.seen(camera, depths, colors)), strict=True)))


def _marks(ground: Ground, views: NDArray[np.float32]) -> list[Marks]:
    return [found() for found in ahead(lambda seen: marks_of(seen, ground), _moving(views))]


def _moving(views: NDArray[np.float32]) -> NDArray[np.float32]:
    """Views (k, side, side) without what most of them show."""
    middle = np.maximum(np.isfinite(views).sum(axis=0) - 1, 0) // 2
    return np.asarray(views - np.take_along_axis(np.sort(views, axis=0), middle[None], axis=0), np.float32)


def marks_of(seen: Image, ground: Ground) -> Marks:
    """The marks of a view (side, side), NaN where it is hidden (Lowe 2004; Arandjelovic and Zisserman 2012)."""
    shown, flat = np.isfinite(seen), np.nan_to_num(seen)
    gray = np.clip(128 + 127 * flat / FULL, 0, 255).astype(np.uint8)
    inside = cv2.erode(shown.astype(np.uint8), np.ones((INSIDE, INSIDE), np.uint8))
    # without precise upscaling all places are a quarter of a pixel off, on all sides of a turn
    finder = cv2.SIFT_create(  # type: ignore[attr-defined]
        contrastThreshold=CLEAR, edgeThreshold=EDGE, enable_precise_upscale=True
    )
    keys, looks = finder.detectAndCompute(gray, inside)
    if not keys:
        return Marks(np.zeros((0, 2)), np.zeros((0, LOOKS, 128), np.float32), np.zeros(0, bool), shown)
    unit = np.sqrt(looks / np.maximum(looks.sum(axis=1, keepdims=True), 1e-9))
    # one mark of several orientations is found several times
    pixels, whose = np.unique(np.round([k.pt for k in keys], 1), axis=0, return_inverse=True)
    clear = np.zeros(len(pixels))
    np.maximum.at(clear, whose.ravel(), [k.response for k in keys])
    kept = np.argsort(-clear, kind="stable")[:MOST]
    described = np.zeros((len(kept), LOOKS, 128), np.float32)
    for out, k in zip(described, kept, strict=True):
        own = unit[whose.ravel() == k][:LOOKS]
        out[: len(own)] = own
    u, v = np.rint(pixels[kept]).astype(int).T
    return Marks((pixels[kept] + 0.5) * ground.pitch - ground.half, described, flat[v, u] > 0, shown)
