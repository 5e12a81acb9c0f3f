"""Images laid out for kernels that look at eight pixels at a time: flat, padded, and reused from frame to frame."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

TILE = 8  # pixels along the edge of a tile, the unit of the first pass
PAD = 2  # rows above and below, and at least as many columns to the right, in which nothing is measured

Flat = NDArray[np.float32]


@dataclass(frozen=True)
class Layout:
    """Pixel (v, u) is entry (v + PAD) * stride + u of every flat image.

    Attributes:
        stride: entries per row, a multiple of 8.
        rows: whole tiles of rows, and the padding.
    """

    stride: int
    rows: int

    def flat(self) -> Flat:
        """An image of zeros."""
        return np.zeros(self.rows * self.stride, np.float32)


@dataclass(frozen=True)
class Work:
    """What the passes over one frame hand to each other.

    Attributes:
        layout: of the flat images.
        x, y: flat, x/z and y/z of every pixel.
        depth: flat, 0 where missing [m].
        slant: flat; says nothing where the depth is missing.
        farthest: (tiles down, tiles across) the largest depth of each tile, 0 for none [m].
    """

    layout: Layout
    x: Flat
    y: Flat
    depth: Flat
    slant: Flat
    farthest: NDArray[np.float32]


@lru_cache(maxsize=4)
def work(camera: Camera) -> Work:
    """Kept for the next frame: fresh memory would cost more than filling it."""
    height, width = camera.shape
    down, across = -(-height // TILE), -(-width // TILE)
    layout = Layout((width + PAD + 7) // 8 * 8, down * TILE + 2 * PAD)
    planes = []
    for axis in range(2):
        plane = layout.flat()
        plane.reshape(layout.rows, layout.stride)[PAD : PAD + height, :width] = camera.rays()[..., axis]
        planes.append(plane)
    tiles = np.zeros((down, across), np.float32)
    return Work(layout, planes[0], planes[1], layout.flat(), layout.flat(), tiles)
