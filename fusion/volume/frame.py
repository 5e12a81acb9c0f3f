"""Images laid out for kernels that look at eight pixels at a time: flat, padded, and reused from frame to frame."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

TILE = 8  # pixels along the edge of a tile, the unit of the first pass
CELL = 4  # pixels along the edge of a square that is looked at as one
PAD = 2  # rows above and below, and at least as many columns to the right, in which nothing is measured
STRIP = 32  # pixels of a row that are looked at in turn; rows are whole strips
NOWHERE = 1e30  # one over the depth where nothing was measured: all that lies there is hidden

Flat = NDArray[np.float32]


@dataclass(frozen=True)
class Layout:
    """Pixel (v, u) is entry (v + PAD) * stride + u of every flat image.

    Attributes:
        stride: entries per row, a multiple of STRIP.
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
        bend: flat, four images one after the other for a lens with distortion: slopes along x/z and y/z are
            a * bend[0] + b * bend[1] and a * bend[2] + b * bend[3] of slopes a, b along u, v; else one value.
        margin: the largest step of x or y from one pixel's centre to its border.
        inverse: flat, one over depth, 0 where missing [1/m].
        weight: flat, the weight of each pixel, where there is any.
        level, slopes, scales: flat, the plane at every pixel, see `planes`.
        filled: for each strip, 1 where one of them has a plane.
        farthest: (rows / CELL, stride / CELL) the largest depth of each cell, 0 for none [m].
    """

    layout: Layout
    x: Flat
    y: Flat
    bend: Flat
    margin: float
    inverse: Flat
    weight: Flat
    level: Flat
    slopes: NDArray[np.int32]
    scales: NDArray[np.int32]
    filled: NDArray[np.int32]
    farthest: NDArray[np.float32]


@lru_cache(maxsize=4)
def work(camera: Camera) -> Work:
    """Kept for the next frame: fresh memory would cost more than filling it."""
    height, width = camera.shape
    down = -(-height // TILE) * TILE
    layout = Layout(-(-(width + PAD) // STRIP) * STRIP, down + 2 * PAD)
    rays = camera.rays()
    x, y = (_padded(layout, rays[..., axis]) for axis in range(2))
    steps = [np.abs(np.diff(rays, axis=axis)) for axis in range(2)]
    margin = 0.5 * max(float(np.max(s[np.isfinite(s)], initial=1.0 / camera.fx)) for s in steps)
    bend = np.zeros(1, np.float32)
    if any(camera.distortion):
        (yv, yu), (xv, xu) = np.gradient(rays[..., 1].astype(float)), np.gradient(rays[..., 0].astype(float))
        turned = np.stack([yv, -yu, -xv, xu]) / (xu * yv - xv * yu)
        bend = np.concatenate([_padded(layout, image) for image in turned])
    cells = np.zeros((down // CELL, layout.stride // CELL), np.float32)
    size = layout.rows * layout.stride
    level = np.full(size, NOWHERE, np.float32)
    slopes, scales, filled = np.zeros(size, np.int32), np.zeros(size, np.int32), np.zeros(size // STRIP, np.int32)
    return Work(layout, x, y, bend, margin, layout.flat(), layout.flat(), level, slopes, scales, filled, cells)


def _padded(layout: Layout, image: NDArray[np.floating]) -> Flat:
    flat = layout.flat()
    height, width = image.shape
    flat.reshape(layout.rows, layout.stride)[PAD : PAD + height, :width] = image
    return flat
