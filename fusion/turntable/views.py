"""What each frame of a turntable scan shows of the object: cropped point maps and sampled source points."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.turntable.below.marks import Marked, Marks
from fusion.turntable.shading import print_of

Array = NDArray[np.float64]


# matching windows and mixed pixels shift the surface this much closer to a silhouette than normals need [px]
BORDER = 1
STEEP = 5.7  # a surface seen at 80 degrees changes its depth by as many pixel widths from one pixel to the next
WINDOW = 5  # [px] about the half width of the matching windows of triangulating cameras (9 px for the first Kinect)


@dataclass(frozen=True)
class Region:
    """Where the object is while it turns, in the camera's frame."""

    # low, high: (3,) box [m]
    low: Array
    high: Array
    still: NDArray[np.bool_] | None = None  # (h, w) pixels of the whole image that never saw a change, or None
    # (h, w) depth [m] from which on a pixel of the whole image shows what stands behind, NaN where that is not known;
    # or None
    wall: NDArray[np.float32] | None = None
    below: Marked | None = None  # what turns below the object, with marks on it

    def holds(self, points: NDArray) -> NDArray[np.bool_]:
        """(...) bool: points (..., 3) inside; NaN is outside."""
        inside = np.ones(points.shape[:-1], bool)
        for k in range(3):  # three values side by side cost numpy seven times as much
            inside &= (points[..., k] >= self.low[k]) & (points[..., k] <= self.high[k])
        return inside

    def grown(self, margin: float) -> "Region":
        """The region with a margin [m] on all sides."""
        return replace(self, low=self.low - margin, high=self.high + margin)

    def cut(self, window: tuple[slice, slice]) -> "Region":
        """The region with its images cut to a window."""
        still = None if self.still is None else self.still[window]
        return replace(self, still=still, wall=None if self.wall is None else self.wall[window])

    def window(self, camera: Camera) -> tuple[slice, slice]:
        """The rows and columns of the image in which the region can be seen."""
        corners = np.stack(np.meshgrid(*zip(self.low, self.high, strict=True)), axis=-1).reshape(-1, 3)
        corners[:, 2] = np.maximum(corners[:, 2], 0.05)
        uv = camera.project(corners)
        u0, v0 = np.floor(uv.min(axis=0)).astype(int) - 8
        u1, v1 = np.ceil(uv.max(axis=0)).astype(int) + 9
        return (
            slice(int(np.clip(v0, 0, camera.height - 16)), int(np.clip(v1, 16, camera.height))),
            slice(int(np.clip(u0, 0, camera.width - 16)), int(np.clip(u1, 16, camera.width))),
        )


@dataclass(frozen=True)
class ObjectView:
    """One frame's share in the alignment."""

    map: PointMap  # everything seen in the window (the background too: it says where the object is not)
    # points, normals, sigma: (n, 3), (n, 3), (n,) of the sampled object surface
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    sigma: NDArray[np.float32]
    # (h, w) what is printed on the surface (see `shading.print_of`), NaN where unknown; None without colour
    print: NDArray[np.float32] | None = None
    tones: NDArray[np.float32] | None = None  # (n,) the same at the points
    marks: Marks | None = None  # on the surface below, where that is looked at

    def of(self, chosen: NDArray) -> "ObjectView":
        """The view with some of its points: their places, or a bool for each."""
        return replace(
            self,
            points=self.points[chosen],
            normals=self.normals[chosen],
            sigma=self.sigma[chosen],
            tones=None if self.tones is None else self.tones[chosen],
        )

    def plain(self) -> "ObjectView":
        """The view without its print."""
        return replace(self, print=None, tones=None)


def view(
    surface: PointMap,
    seen: NDArray[np.bool_],
    color: NDArray[np.uint8] | None = None,
    marks: Marks | None = None,
) -> ObjectView:
    """The view of one frame.

    Args:
        surface: what the frame shows, in the window of the region (see `Region.window` and `crop`).
        seen: (h, w) its pixels that take part, see `usable`.
        color: (h, w, 3) of the same pixels, or None.
        marks: on the surface below the object, or None.
    """
    known = surface.points[seen], surface.normals[seen], surface.sigma[seen]
    if color is None:
        return ObjectView(surface, *known)
    tones = print_of(color, surface.normals, seen)
    return ObjectView(surface, *known, tones, tones[seen], marks)


def usable(surface: PointMap, region: Region) -> NDArray[np.bool_]:
    """(h, w) pixels that take part: on the object, not at a grazing angle, not beside a step or hole.

    Args:
        surface: what the frame shows, in the window of the region.
        region: where the object is; its images cut to the same window.
    """
    assert surface.incidence is not None
    known = np.isfinite(surface.normals[..., 0])
    # a square of the house's border around every hole and step takes no part
    known &= cv2.erode(known.astype(np.uint8), np.ones((2 * BORDER + 1, 2 * BORDER + 1), np.uint8)) > 0
    known &= before_wall(surface, region) & (surface.incidence < np.deg2rad(75)) & ~overlaid(surface)
    if region.still is not None:  # what stands still in the image says "no turn", whatever turns behind it
        known &= ~region.still
    return np.asarray(known)


def before_wall(surface: PointMap, region: Region) -> NDArray[np.bool_]:
    """(h, w) pixels that lie within the region and before what stands behind it; arguments as of `usable`."""
    inside = region.holds(surface.points)
    return inside if region.wall is None else inside & ~(surface.points[..., 2] >= region.wall)


def overlaid(surface: PointMap) -> NDArray[np.bool_]:
    """(h, w) pixels before a background so near in the image that a matching window may have spread them over it."""
    camera = surface.camera
    if not camera.principle.triangulates:
        return np.zeros(camera.shape, bool)
    depth = surface.points[..., 2]
    around = np.ones((2 * WINDOW + 1, 2 * WINDOW + 1), np.uint8)
    farthest = cv2.dilate(np.nan_to_num(depth).astype(np.float32), around)
    return np.asarray(farthest - depth > STEEP * WINDOW * depth / camera.fx)
