"""Which vertices an image shows, and how well: nothing in the way, not at a rim, seen from the front and from near.

At rims the image shows the background: poses, depth and the lens are off by a pixel or two there, and pixels mix what
lies on both sides. So the distance to the next rim counts, whatever it is the rim of: of the mesh, of one part of it
before another, of something that the depth camera measured in front of it, of a place it looked through.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.coloring.images import SeenByImage
from fusion.coloring.surface import RayMesh
from fusion.geometry.camera import Camera

GRAZING = 0.2  # cosine of 78 degrees: beyond, a pixel covers five times its width of the surface (guess)
BEND = 4.0  # pixel widths; a convex right angle seen evenly from both sides bends by 2, at 14 degrees by 4.3
BEHIND = 3.0  # pixel widths: at 65 degrees the surface moves by as much within a pixel and a half
DISAGREE = 0.02  # of the depth: beyond the noise of depth cameras, below what stands in the way (guess)
NEAREST, CLEAR = 1.0, 6.0  # coarse pixels from a rim: below, nothing is used; from there on all is good (guess)


@dataclass(frozen=True)
class VisibleVertices:
    """The vertices that an image shows: their index (k,), pixels (k, 2) and weight (k,)."""

    index: NDArray[np.int64]
    pixels: NDArray[np.float64]
    weight: NDArray[np.float32]


def visible(surface: RayMesh, seen: SeenByImage, front: NDArray[np.float32] | None = None) -> VisibleVertices:
    """The vertices of a surface that an image shows; `front` is its depth in coarse pixels where that is known.

    The weight falls with the square of the angle's cosine and of the distance, as fewer pixels share the surface, and
    with the square of the distance to the next rim where that is near.
    """
    camera, coarse = seen.camera, seen.coarse
    front = surface.depth(coarse, seen.T_world_camera) if front is None else front
    clear = _from_rims(front, seen.measured, coarse)
    index = surface.seen_by(camera, seen.T_world_camera)
    cosine = surface.cosine(index, seen.T_world_camera)
    index, cosine = index[cosine > GRAZING], cosine[cosine > GRAZING]
    points = surface.points(index, seen.T_world_camera)
    z, pixels = points[2], camera.project(points.T)
    inside, u, v = _coarse_pixels(pixels, camera, coarse)
    rim = clear[v, u]
    shown = inside & (rim >= NEAREST) & (z < front[v, u] + BEHIND * z / coarse.fx)
    weight = (cosine / z * np.minimum(rim / CLEAR, 1)) ** 2
    return VisibleVertices(index[shown], pixels[shown], weight[shown].astype(np.float32))


def _coarse_pixels(
    pixels: NDArray[np.float64], camera: Camera, coarse: Camera
) -> tuple[NDArray[np.bool_], NDArray[np.int64], NDArray[np.int64]]:
    """Who of pixels (n, 2) is within the picture, and the column and row of the coarse pixel around each."""
    u, v = pixels.T
    inside = (u >= -0.5) & (u < camera.width - 0.5) & (v >= -0.5) & (v < camera.height - 0.5)
    share = coarse.fx / camera.fx  # a coarse pixel is the mean of whole ones
    column = np.floor((np.where(inside, u, 0) + 0.5) * share).astype(np.int64)
    row = np.floor((np.where(inside, v, 0) + 0.5) * share).astype(np.int64)
    return inside, np.minimum(column, coarse.width - 1), np.minimum(row, coarse.height - 1)


def _from_rims(front: NDArray[np.float32], measured: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
    """(h, w) distance [px] of each pixel of the surface from the next rim, 0 at rims and beside the surface.

    Args:
        front: (h, w) depth of the surface [m], infinite where there is none.
        measured: (h, w) what the depth camera saw [m], NaN where nothing.
    """
    with np.errstate(invalid="ignore"):  # of NaN and infinity no comparison is meant to hold
        blocked = measured < front * (1 - DISAGREE)
        # the nearest of nine: what was looked through must lie behind all around
        near = np.where(np.isfinite(measured), measured, np.inf).astype(np.float32)
        near = np.asarray(cv2.erode(near, np.ones((3, 3), np.uint8)))
        through = np.isfinite(near) & (near > front * (1 + DISAGREE))
    closeness = np.where(np.isfinite(front), 1 / front, 0).astype(np.float32)  # of a plane it is linear in the pixels
    wide = np.pad(closeness, 1, mode="edge")
    across = np.abs(wide[1:-1, :-2] - 2 * closeness + wide[1:-1, 2:]) * camera.fx
    down = np.abs(wide[:-2, 1:-1] - 2 * closeness + wide[2:, 1:-1]) * camera.fy
    clear = np.isfinite(front) & ~blocked & ~through & (np.maximum(across, down) <= BEND * closeness)
    return np.asarray(cv2.distanceTransform(clear.astype(np.uint8), cv2.DIST_L2, 5), np.float32)
