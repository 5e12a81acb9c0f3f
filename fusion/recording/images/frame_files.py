"""The image files behind a recording's frames, in the order of time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.recording.cameras.turned import turned
from fusion.recording.images.read import read_color, read_counts

# TUM's associate.py joins depth and colour up to 0.02 s apart
ASSOCIATION_SECONDS = 0.02
# stamps written with six decimals must not fall out by rounding
ROUNDING_SECONDS = 1e-5
# largest count: what many devices write where they measured nothing
INVALID_COUNT = 65535


@dataclass(frozen=True)
class FrameFiles:
    """Where the images of each frame lie."""

    folder: Path  # what the names are relative to
    depth: Sequence[str]  # file name per frame
    # color, ir: file name per frame, None where a frame has none; empty when no frame has one
    color: Sequence[str | None] = ()
    ir: Sequence[str | None] = ()
    # as `color`, images in the pixels of the colour camera, which is not where the depth camera is
    color_apart: Sequence[str | None] = ()
    # reads a depth file as counts (height, width) uint16, 0 and 65535 missing; given the camera's shape
    read_depth: Callable[[Path, tuple[int, int]], NDArray[np.uint16]] = read_counts
    # depth [m] of counts where it is not counts / depth_scale, or None
    to_metres: Callable[[NDArray[np.uint16]], NDArray[np.float32]] | None = None
    steps_back: int = 0  # how many stamps of the depth list were earlier than the one before
    # list name: (images without a depth frame in time, images in the list)
    unmatched: dict[str, tuple[int, int]] = field(default_factory=dict)
    # quarter turns against the clock of colour images that have the sides of their camera the other way round
    turn: int = 0

    def read_color(self, name: str, shape: tuple[int, int]) -> NDArray[np.uint8]:
        """(h, w, 3) RGB of a colour image whose camera has this (height, width). Raises RecordingError."""
        return turned(read_color(self.folder / name, shape), shape, self.turn)


def associate(
    stamps: NDArray[np.float64], other: NDArray[np.float64], tolerance: float = ASSOCIATION_SECONDS
) -> NDArray[np.intp]:
    """Index into `other` (m,) of the image belonging to each stamp (n,), -1 where there is none.

    A pair must be the nearest of each other and no more than the tolerance [s] apart, so no image is used twice.
    """
    if not len(stamps) or not len(other):
        return np.full(len(stamps), -1, np.intp)
    forth, back = _nearest(stamps, other), _nearest(other, stamps)
    close = np.abs(other[forth] - stamps) <= tolerance + ROUNDING_SECONDS
    mutual = back[forth] == np.arange(len(stamps))
    return np.where(close & mutual, forth, -1)


def in_time(stamps: NDArray[np.float64], known: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n,) True for each stamp that has one of `known` (m,) close enough to belong to it."""
    if not len(stamps) or not len(known):
        return np.zeros(len(stamps), bool)
    return np.abs(known[_nearest(stamps, known)] - stamps) <= ASSOCIATION_SECONDS + ROUNDING_SECONDS


def _nearest(stamps: NDArray[np.float64], known: NDArray[np.float64]) -> NDArray[np.intp]:
    """Index of the nearest of `known` (m,), in any order, for each stamp (n,); the first of equals."""
    order = np.argsort(known, kind="stable")
    ordered = known[order]
    right = np.minimum(np.searchsorted(ordered, stamps), len(known) - 1)
    left = np.maximum(right - 1, 0)
    nearer = np.abs(ordered[left] - stamps) <= np.abs(ordered[right] - stamps)
    best = np.where(nearer, left, right)
    # of equal stamps the first
    return order[np.searchsorted(ordered, ordered[best])]
