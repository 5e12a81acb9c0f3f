"""Images that raycasts are written to. They serve again once nobody holds them any longer: fresh ones would have to be
filled with NaN, most of which is still there where nothing was seen."""

from contextlib import suppress
from dataclasses import dataclass
from sys import getrefcount

import numpy as np
from numpy.typing import NDArray

PIECE = 32  # pixels of a row that are looked at in turn
MOST = 6  # kept, of all sizes together
OURS = 2  # references to an array that nobody else holds: the canvas, and the one that the count itself takes


@dataclass(frozen=True)
class Canvas:
    """What a raycast fills in.

    Attributes:
        depth: (h, w) float32.
        points, normals: (3 h w,) float32.
        used: (h * pieces of a row,) int32, 0 where a piece of the three images is NaN.
    """

    depth: NDArray[np.float32]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    used: NDArray[np.int32]

    def shown(self) -> list[NDArray[np.float32]]:
        """Depth (h, w), points and normals (h, w, 3); read only, as what is NaN here is not written again."""
        h, w = self.depth.shape
        images = [self.depth.view(), self.points.reshape(h, w, 3), self.normals.reshape(h, w, 3)]
        for image in images:
            image.flags.writeable = False
        return images

    def held(self) -> bool:
        """Whether anyone else holds an image, or a view of one."""
        return max(getrefcount(self.depth), getrefcount(self.points), getrefcount(self.normals)) > OURS


_kept: list[Canvas] = []


def take(h: int, w: int) -> Canvas:
    """A canvas for images of h rows and w columns; as long as it is not given back, nobody else gets it."""
    for _ in range(len(_kept)):
        with suppress(IndexError):  # another thread has taken it
            canvas = _kept.pop(0)
            if canvas.depth.shape == (h, w) and not canvas.held():
                return canvas
            _kept.append(canvas)
    depth, points, normals = (np.empty(shape, np.float32) for shape in ((h, w), h * w * 3, h * w * 3))
    return Canvas(depth, points, normals, np.ones(h * -(-w // PIECE), np.int32))


def give_back(canvas: Canvas) -> None:
    """It may be taken again; until they are let go, its images stay what they are."""
    _kept.append(canvas)
    del _kept[:-MOST]
