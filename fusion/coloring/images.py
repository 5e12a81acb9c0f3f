"""The colour images of a recording: which camera took them, from where, and what the depth camera saw meanwhile."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, transform
from fusion.geometry.trajectory import Trajectory
from fusion.recording.recording import Recording


@dataclass(frozen=True)
class SeenByImage:
    """What is known of what one colour image looked at."""

    camera: Camera  # took the image
    coarse: Camera  # the same, halved some times: what stands in the way is judged in its pixels
    T_world_camera: Array  # (4, 4)
    measured: NDArray[np.float32]  # (h, w) depth of the coarse pixels [m], NaN where none was measured


WIDEST = 480  # [px] visibility is judged in images halved until they are no wider


@dataclass(frozen=True)
class ColorImage:
    """A colour image."""

    color: NDArray[np.uint8]  # (h, w, 3) uint8 RGB
    depth: NDArray[np.float32]  # what the depth camera measured at that moment [m], in its own pixels

    def sampled(self, pixels: Array) -> NDArray[np.float32]:
        """Colours (n, 3) at pixels (n, 2) within the image, bilinear."""
        return bilinear(self.color, pixels)


def bilinear(picture: NDArray[Any], pixels: Array) -> NDArray[np.float32]:
    """Values (n, 3) of a picture (h, w, 3) at pixels (n, 2) within it."""
    h, w = picture.shape[:2]
    u, v = (np.clip(pixels[:, i], 0, size - 1) for i, size in ((0, w), (1, h)))
    left, top = np.minimum(u.astype(int), max(w - 2, 0)), np.minimum(v.astype(int), max(h - 2, 0))
    right, below = np.minimum(left + 1, w - 1), np.minimum(top + 1, h - 1)
    a, b = (u - left).astype(np.float32)[:, None], (v - top).astype(np.float32)[:, None]
    upper = (1 - a) * picture[top, left] + a * picture[top, right]
    lower = (1 - a) * picture[below, left] + a * picture[below, right]
    return np.asarray((1 - b) * upper + b * lower, np.float32)


@dataclass(frozen=True)
class ColorImages:
    """Where the colour images of a recording are and where they were taken."""

    recording: Recording  # whose
    camera: Camera  # took them; the depth camera where they are in its pixels
    T_color_depth: Array  # (4, 4)
    frames: NDArray[np.int64]  # those that may have one
    apart: bool  # the colour camera has its own pixels
    coarse: Camera = field(init=False)

    def __post_init__(self) -> None:
        coarse = self.camera
        while coarse.width > WIDEST:
            coarse = coarse.halved()
        object.__setattr__(self, "coarse", coarse)

    def read(self, index: int) -> ColorImage | None:
        """One image, or None where the frame has none. RecordingError where it cannot be read, or has another size."""
        frame = self.recording[index]
        color = frame.color
        if self.apart:
            color = self.recording.color_apart(index)
        if "color" in frame.unfit or (color is not None and color.shape[:2] != self.camera.shape):
            raise RecordingError("a colour image is of another size", self.recording.path, f"frame {index}")
        return None if color is None else ColorImage(color, frame.depth)

    def spread(self, trajectory: Trajectory, most: int) -> list[int]:
        """Up to `most` frames with a pose and perhaps an image, as different in place and direction as can be."""
        able = self.frames[trajectory.valid[self.frames]]
        if len(able) <= most:
            return [int(i) for i in able]
        poses = trajectory.poses[able]
        size = max(float(np.linalg.norm(np.ptp(poses[:, :3, 3], axis=0))), 1e-9)
        # a metre counts as much as it is of the whole path; directions by their sine
        place = np.hstack([poses[:, :3, 3] / size, poses[:, :3, 2]])
        chosen, nearest = [0], np.full(len(able), np.inf)
        for _ in range(most - 1):
            nearest = np.minimum(nearest, np.linalg.norm(place - place[chosen[-1]], axis=1))
            chosen.append(int(nearest.argmax()))
        return sorted({int(i) for i in able[chosen]})

    def T_world_color(self, T_world_depth: Array) -> Array:
        """(4, 4) of the colour camera.

        The images are taken for simultaneous. Moving the pose on to the colour's time stamp made it worse: on TUM
        fr1_rpy, views of a vertex then differ by 48 counts instead of 39, as the stamps of both are off by 20 ms.
        """
        return np.asarray(T_world_depth @ inverse(self.T_color_depth))

    def seen(self, image: ColorImage, T_world_color: Array) -> SeenByImage:
        """What is known of what an image shows: the camera's place, and the measured depth in coarse colour pixels."""
        return SeenByImage(self.camera, self.coarse, T_world_color, self._measured(image.depth))

    def _measured(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Depth (h, w) [m] as the colour camera's coarse pixels see it, NaN where nothing was measured."""
        h, w = self.coarse.shape
        if not self.apart:
            step = self.camera.width // w
            return depth[step // 2 :: step, step // 2 :: step][:h, :w]
        some = self.recording.camera.points(depth)[::2, ::2].reshape(-1, 3)
        points = transform(self.T_color_depth, some[np.isfinite(some[:, 2])].astype(float))
        points = points[points[:, 2] > 1e-3]
        u, v = np.rint(np.clip(self.coarse.project(points), -9, 99999)).astype(int).T
        inside = (u >= 0) & (u < w) & (v >= 0) & (v < h)
        nearest = np.full(h * w, np.inf, np.float32)
        np.minimum.at(nearest, v[inside] * w + u[inside], points[inside, 2].astype(np.float32))
        return np.where(np.isfinite(nearest), nearest, np.nan).reshape(h, w).astype(np.float32)


def color_images(recording: Recording) -> ColorImages | None:
    """The colour images of a recording, or None where it names none."""
    camera, has = recording.camera, recording.has_color
    frames = np.arange(len(recording)) if has is None else np.flatnonzero(has)
    if not len(frames):
        return None
    if recording.color_is_apart and camera.color is not None and camera.T_color_depth is not None:
        return ColorImages(recording, camera.color, camera.T_color_depth, frames, True)
    return ColorImages(recording, camera, np.eye(4), frames, False)
