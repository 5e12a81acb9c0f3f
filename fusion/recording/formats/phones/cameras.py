"""The cameras that phones' recordings state, one a frame, brought to their depth images."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fusion.files.tree import Tree
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.laid import in_proportion, laid_as_depth, poses_laid
from fusion.recording.cameras.own_cameras import common_camera
from fusion.recording.formats.phones.arkit import camera_of, depth_camera
from fusion.recording.images.header import exif_turn
from fusion.recording.images.read import size_in
from fusion.recording.streamed import with_color_of


@dataclass(frozen=True)
class Cameras:
    """What is known of a recording's cameras."""

    camera: Camera  # of depth, with that of colour where this has another size
    own: dict[int, Camera]  # by frame, the camera that saw it where that is another
    turn: int = 0  # quarter turns by which the stated cameras were brought to the depth images
    pictures: int = 0  # those that colour images as stored need for it
    stored: tuple[int, int] | None = None  # (height, width) of these; None: there are none
    told: tuple[str, ...] = ()  # about it

    @property
    def wanted(self) -> tuple[int, int] | None:
        """(height, width) that notes (EXIF) of pictures may turn them to; None where they are turned otherwise."""
        return None if self.pictures else (self.camera.color or self.camera).shape

    def poses(
        self, stated: Trajectory | None, depth: Callable[[int], NDArray[np.float32]]
    ) -> tuple[Trajectory | None, list[str]]:
        """Those of the depth camera; `depth`: (h, w) [m] of a frame, raises RecordingError."""
        return (stated, []) if stated is None or not self.turn else poses_laid(stated, self.turn, depth, self.camera)


class Pictured(Protocol):
    """Images of a recording, by frame."""

    @property
    def tree(self) -> Tree: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    def depth(self, index: int) -> NDArray[np.float32]: ...
    def color(self, index: int) -> NDArray[np.uint8] | None: ...


def cameras_of(stated: Array, size: tuple[int, int], images: Pictured, pictures: Iterable[str]) -> Cameras:
    """The cameras of a recording.

    Args:
        stated: (n, 4) fx, fy, and the principal point from the corner [px] of each frame.
        size: (width, height) of the colour images that these are of.
        images: the recording's.
        pictures: names of colour images, of which the first that there is tells how they are stored.

    Raises:
        RecordingError: depth has other proportions than colour.
    """
    height, width = images.shape
    seen, asked = _first(images.tree, pictures)
    laid = laid_as_depth(stated, size, images.depth, (width, height), images.color, asked, images.tree.path)
    camera = depth_camera(camera_of(*laid.size, *laid.stated[0].tolist()), width, height)
    scale = np.array([width / laid.size[0], height / laid.size[1]])
    inside = np.hstack([laid.stated[:, :2] * scale, laid.stated[:, 2:] * scale - 0.5])
    camera, own, more = common_camera(camera, inside)
    # pictures may be saved in another size than they were taken in, and lie another way
    fitting = None if seen is None else next((s for s in (seen, seen[::-1]) if in_proportion(s, (width, height))), None)
    if fitting is not None:
        camera = with_color_of(camera, camera.resized(*fitting))
    stored = None if seen is None else seen[::-1]
    return Cameras(camera, own, laid.turn, laid.pictures, stored, (*laid.told, *more))


def _first(tree: Tree, names: Iterable[str]) -> tuple[tuple[int, int] | None, int]:
    """(width, height) [px] of the first colour image that there is, and the quarter turns that its notes ask for."""
    name = next((one for one in names if tree.has(one)), None)
    if name is None:
        return None, 0
    data = tree.read(name, "an image")
    return size_in(data, tree.where(name)), exif_turn(data)
