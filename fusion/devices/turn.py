"""Seeing that a table has turned once: the picture is again as like the first one as its own neighbours in time are."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.devices.source import SourceFrame

ACROSS = 64  # pixels of the small pictures that are compared
# a view is again the first one when it differs by no more than this many steps of the table do: half a step at most
# lies between the nearest view and the first, but noise may be all that there is in a step; and it is past the first
# one when it differs by this many (guesses)
AGAIN, PAST = 1.1, 1.3
# and it was away when it differed by this many: two views that share little differ by 2 steps of 12 degrees and by more
# of smaller ones (measured by tests/devices/test_turn.py; a guess between that and what noise alone does, 1)
AWAY = 1.6
FEWEST = 4  # steps whose median tells a usual one


class TurnWatch:
    """Is shown each frame; tells when one turn was seen.

    A log of the table's angle is believed. Else small pictures are compared, of depth and, where there is one, of
    brightness, which tells apart the sides of what has several alike. What looks the same from two sides in both turns
    too early, what looks the same from all sides never.
    """

    def __init__(self) -> None:
        self._first: NDArray | None = None
        self._before: NDArray | None = None
        self._began: float | None = None
        self._steps: list[float] = []
        self._away = False
        self._again = False

    def seen(self, frame: SourceFrame) -> bool:
        """True once this frame has come past the first view again."""
        angle = frame.log.get("turntable_deg", np.nan)
        if np.isfinite(angle):
            self._began = angle if self._began is None else self._began
            return abs(angle - self._began) >= 360
        return self._compared(_small(frame))

    def _compared(self, small: NDArray) -> bool:
        if self._first is None or self._before is None:
            self._first = self._before = small
            return False
        step, away = _difference(small, self._before), _difference(small, self._first)
        self._before = small
        self._steps.append(step)
        usual = float(np.median(self._steps))
        if not self._away:
            self._away = len(self._steps) >= FEWEST and away > AWAY * usual
            if self._away:
                self._steps = self._steps[-FEWEST:]  # those before may be of a table that stood still
            return False
        self._again = self._again or away <= AGAIN * usual
        return self._again and away > PAST * usual  # past it: the last frame of the turn overlaps the first


def _small(frame: SourceFrame) -> NDArray[np.float32]:
    """(2, h, w) depth [m], NaN where missing, and brightness 0 to 1, NaN where there is none."""
    height, width = frame.depth.shape
    size = min(ACROSS, width), max(1, height * min(ACROSS, width) // width)
    held = np.isfinite(frame.depth)
    share = cv2.resize(held.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    total = cv2.resize(np.where(held, frame.depth, 0).astype(np.float32), size, interpolation=cv2.INTER_AREA)
    depth = np.where(share > 0.5, total / np.maximum(share, 0.5), np.nan)
    color = frame.color if frame.color is not None else frame.color_apart
    light = frame.ir if color is None else cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    if light is None:
        return np.stack([depth, np.full_like(depth, np.nan)]).astype(np.float32)
    brightest = 255.0 if color is not None else max(float(light.max()), 1.0)
    dim = cv2.resize(light.astype(np.float32), size, interpolation=cv2.INTER_AREA) / brightest
    return np.stack([depth, dim]).astype(np.float32)


def _difference(one: NDArray, other: NDArray) -> float:
    """How different two small pictures are: depth in centimetres, brightness in hundredths, where both have one.

    A pixel counts for at most 5 of either, so that the edges of things do not outweigh their shape (guess).
    """
    gap = np.abs(one - other) * 100
    seen = np.isfinite(gap)
    appeared = np.isfinite(one[0]) ^ np.isfinite(other[0])
    total = np.minimum(np.where(seen, gap, 0), 5).sum() + 5 * appeared.sum()
    return float(total / max(seen.sum() + appeared.sum(), 1))
