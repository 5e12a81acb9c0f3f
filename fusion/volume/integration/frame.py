"""Images laid out for kernels that look at eight pixels at a time: flat, padded, and reused from frame to frame.

What a camera fixes is shared by all who use it, and read only; what a frame fills in belongs to one volume."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

CELL = 4  # pixels along the edge of a square that is looked at as one
PAD = 2  # rows above and below, and at least as many columns to the right, in which nothing is measured
STRIP = 32  # pixels of a row that are looked at in turn; rows are whole strips
NOWHERE = 1e30  # one over the depth where nothing was measured: all that lies there is hidden

Flat = NDArray[np.float32]


class FrameImages(NamedTuple):
    """A frame as it is fused."""

    depth: Flat  # (h, w) [m], anything not finite and positive is missing
    weight: Flat | None  # (h, w), no positive one is missing too; None for 1
    color: NDArray[np.uint8] | None  # (h, w, 3), or None


@dataclass(frozen=True)
class Layout:
    """Pixel (v, u) is entry (v + PAD) * stride + u of every flat image."""

    stride: int  # entries per row, a multiple of STRIP
    rows: int  # whole cells of rows, and the padding

    def flat(self) -> Flat:
        """An image of zeros."""
        return np.zeros(self.rows * self.stride, np.float32)


@dataclass(frozen=True)
class Geometry:
    """What is known of a camera's images before anything is measured; read only."""

    layout: Layout  # of the flat images
    # x, y: flat, x/z and y/z of every pixel
    x: Flat
    y: Flat
    # flat, four images one after the other for a lens with distortion: slopes along x/z and y/z are a * bend[0] + b *
    # bend[1] and a * bend[2] + b * bend[3] of slopes a, b along u, v; else one value
    bend: Flat
    margin: float  # the largest step of x or y from one pixel's centre to its border
    cells: Flat  # (4, rows / CELL, stride / CELL) x/z and y/z of the middle of each cell, and from there to its borders


@dataclass(frozen=True)
class Work:
    """What the passes over one frame hand to each other, and what they leave for the next one."""

    geometry: Geometry  # of the camera
    inverse: Flat  # flat, one over depth, 0 where missing [1/m]
    weight: Flat  # flat, the weight of each pixel, where there is any
    # level, slopes, scales: flat, the plane at every pixel, see `planes`
    level: Flat
    slopes: NDArray[np.int32]
    scales: NDArray[np.int32]
    # the same three, from the pixel before the first one on, one row up and eight to the left
    shifted: tuple[Flat, NDArray[np.int32], NDArray[np.int32]]
    # for each strip of a row of cells, 1 where anything is measured, and 2 more where planes stand
    filled: NDArray[np.int32]
    farthest: NDArray[np.float32]  # (rows / CELL, stride / CELL) the largest depth of each cell, 0 for none [m]


@lru_cache(maxsize=4)
def geometry(camera: Camera) -> Geometry:
    """The same for all frames of a camera."""
    height, width = camera.shape
    down = -(-height // CELL) * CELL
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
    cells = _cells(rays, margin, (down // CELL, layout.stride // CELL))
    for shared in (x, y, bend, cells):
        shared.flags.writeable = False
    return Geometry(layout, x, y, bend, margin, cells)


def work(camera: Camera) -> Work:
    """Images for one frame after another of a camera, as nothing was measured yet."""
    known = geometry(camera)
    layout = known.layout
    farthest = np.zeros(known.cells.shape[1:], np.float32)
    size = layout.rows * layout.stride
    level = np.full(size, NOWHERE, np.float32)
    slopes, scales = np.zeros(size, np.int32), np.zeros(size, np.int32)
    filled, skip = np.zeros(farthest.size * CELL // STRIP, np.int32), (PAD - 1) * layout.stride - 8
    shifted = (level[skip:], slopes[skip:], scales[skip:])
    return Work(known, layout.flat(), layout.flat(), level, slopes, scales, shifted, filled, farthest)


def whole(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image of whole cells of rows and whole strips: itself, or with zeros below and to the right."""
    height, width = image.shape
    down, across = -height % CELL, -width % STRIP
    return np.pad(image, ((0, down), (0, across))) if down or across else image


def _cells(rays: NDArray[np.floating], margin: float, shape: tuple[int, ...]) -> Flat:
    v, u = (np.arange(0, n, CELL) for n in rays.shape[:2])
    last = [np.minimum(at + CELL - 1, n - 1) for at, n in zip((v, u), rays.shape[:2], strict=True)]
    a, b = rays[np.ix_(v, u)], rays[np.ix_(*last)]
    cells = np.zeros((4, *shape), np.float32)
    cells[:, : len(v), : len(u)] = np.moveaxis(np.dstack([0.5 * (a + b), 0.5 * np.abs(b - a) + margin]), 2, 0)
    return cells


def _padded(layout: Layout, image: NDArray[np.floating]) -> Flat:
    flat = layout.flat()
    height, width = image.shape
    flat.reshape(layout.rows, layout.stride)[PAD : PAD + height, :width] = image
    return flat
