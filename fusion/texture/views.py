"""The colour images that a surface is painted from, one after the other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.coloring.color_mesh import ENOUGH, SHARE
from fusion.coloring.images import ColorImage, ColorImages, bilinear, color_images
from fusion.coloring.surface import RayMesh
from fusion.coloring.visible import VisibleVertices, visible
from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.progress import each
from fusion.recording.recording import Recording

COARSE = 3.0  # [px of the coarse picture] standard deviation; below it print lies, above it light (guess)


@dataclass(frozen=True)
class Bands:
    """An image of the surface: (h, w, 3) float32 each; their sum is the image where the surface is."""

    low: NDArray[np.float32]  # what is coarse; near a rim the mean of what lies on this side of it
    high: NDArray[np.float32]  # what is fine


def bands_of(color: NDArray[np.uint8], front: NDArray[np.float32]) -> Bands:
    """The bands of an image.

    Args:
        color: (h, w, 3) uint8.
        front: (h', w') depth of the surface in a coarser picture of the same camera, infinite where there is none.
    """
    h, w = color.shape[:2]
    low, high = np.zeros((h, w, 3), np.float32), np.zeros((h, w, 3), np.float32)
    known = np.isfinite(front)
    if not known.any():
        return Bands(low, high)
    # a pixel in from the rim: poses are off by about so much
    inner = cv2.erode(known.astype(np.uint8), np.ones((3, 3), np.uint8))
    share = np.asarray(cv2.resize(inner, (w, h), interpolation=cv2.INTER_NEAREST))
    part = _around(known, (h, w))
    weight, picture = share[part].astype(np.float32), color[part].astype(np.float32)
    sigma = COARSE * w / front.shape[1]
    # by boxes, as they cost the same at any width: three of them are a Gaussian to a few percent
    size = 2 * round(sigma) + 1
    both = np.dstack([picture * weight[..., None], weight])
    for _ in range(3):
        both = np.asarray(cv2.blur(both, (size, size)))
    mean = both[..., :3] / np.maximum(both[..., 3:], 1e-3)
    low[part] = np.where(both[..., 3:] > 1e-3, mean, picture)
    high[part] = picture - low[part]
    return Bands(low, high)


def _around(known: NDArray[np.bool_], shape: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of a picture of some shape that hold what is known in a coarser one, and a little more."""
    out = []
    for axis in (0, 1):
        found, share = np.flatnonzero(known.any(axis=1 - axis)), shape[axis] / known.shape[axis]
        out.append(slice(max(int((found[0] - 6) * share), 0), int((found[-1] + 7) * share)))
    return out[0], out[1]


@dataclass(frozen=True)
class Shot:
    """An image that was read."""

    number: int  # among all that are used
    # source, image: whose it is, and what is in it
    source: ColorImages
    image: ColorImage
    T_world_color: Array  # (4, 4)
    front: NDArray[np.float32]  # (h', w') depth of the surface in coarse pixels, infinite where there is none
    bands: Bands  # the image, taken apart

    def shows(self, surface: RayMesh) -> VisibleVertices:
        """The points of a surface that it shows."""
        return visible(surface, self.source.seen(self.image, self.T_world_color), self.front)

    def at(self, pixels: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Coarse and fine colours (k, 3) at pixels (k, 2)."""
        return bilinear(self.bands.low, pixels), bilinear(self.bands.high, pixels)


@dataclass(frozen=True)
class Views:
    """Images that are used: which of which recording, and from where."""

    # sources, frames: of each image, whose it is and which frame
    sources: list[ColorImages]
    frames: list[int]
    recordings: list[int]  # of each image, the number of its recording
    T_world_color: Array  # (views, 4, 4)

    @staticmethod
    def of(taken: Sequence[tuple[Recording, Trajectory]]) -> "Views":
        """Well spread ones of recordings with their trajectories."""
        sources, frames, recordings, poses = [], [], [], []
        for number, (recording, course) in enumerate(taken):
            source = color_images(recording)
            if source is not None:
                for index in source.spread(course, max(ENOUGH, int(SHARE * len(course)))):
                    sources.append(source)
                    frames.append(index)
                    recordings.append(number)
                    poses.append(source.T_world_color(course.poses[index]))
        return Views(sources, frames, recordings, np.reshape(poses, (-1, 4, 4)))

    def pixel(self, point: Array) -> float:
        """What a pixel covers at a point (3,) [m]: the median of all views."""
        widths = np.linalg.norm(self.T_world_color[:, :3, 3] - point, axis=1)
        return float(np.median(widths / [source.camera.fx for source in self.sources]))

    def shots(self, surface: RayMesh, what: str) -> Iterator[Shot]:
        """Each image that can be read, with its bands; one at a time."""
        for number in each(range(len(self.frames)), what):
            source, T = self.sources[number], self.T_world_color[number]
            try:
                image = source.read(self.frames[number])
            except RecordingError:  # damaged, missing, or of another size
                continue
            if image is not None:
                front = surface.depth(source.coarse, T)
                yield Shot(number, source, image, T, front, bands_of(image.color, front))
