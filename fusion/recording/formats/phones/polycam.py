"""Polycam's raw data: `keyframes/` with `depth/`, `cameras/`, `images/`, `confidence/`; a folder or a zip archive.

Described in github.com/PolyCam/polyform.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import Content, Metres
from fusion.files.json_file import json_in
from fusion.files.reading import decoded
from fusion.files.tree import Tree, is_zip, open_tree
from fusion.geometry.camera import Camera
from fusion.geometry.pose import is_rigid
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats.phones.arkit import (
    COARSE,
    LIDAR,
    UNKNOWN,
    Confidence,
    confidence_of,
    from_arkit,
    noisier,
    sized,
    sure,
)
from fusion.recording.formats.phones.cameras import Cameras, cameras_of
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.images.read import color_in, counts_in, grey_in, size_in
from fusion.recording.native.camera_file import Centre, Focal, Size
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

KEYFRAMES = "keyframes"
DEPTH_SCALE = 1000.0  # millimetres
Turn = Annotated[float, Meta(ge=-1.1, le=1.1, description="of a rotation")]


class PolycamCamera(Struct, frozen=True, kw_only=True):
    """The camera of one image."""

    fx: Focal
    fy: Focal
    cx: Centre
    cy: Centre
    width: Size
    height: Size
    t_00: Turn
    t_01: Turn
    t_02: Turn
    t_03: Metres
    t_10: Turn
    t_11: Turn
    t_12: Turn
    t_13: Metres
    t_20: Turn
    t_21: Turn
    t_22: Turn
    t_23: Metres


@dataclass(frozen=True)
class PolycamImages:
    """The images of a recording."""

    tree: Tree  # the folder or archive
    names: list[str]  # of the frames: microseconds
    pictures: str  # the folder of the colour images
    shape: tuple[int, int]  # (height, width) of the depth images
    confident: Confidence = UNKNOWN  # what confidence is worth
    # (height, width) that colour images are turned to where their notes (EXIF) ask for it; None: never
    wanted: tuple[int, int] | None = None

    def counts(self, index: int) -> NDArray[np.uint16]:
        """(h, w) millimetres of a frame, 0 where missing. Raises RecordingError."""
        return counts_in(*self._file(f"{KEYFRAMES}/depth/{self.names[index]}.png"), self.shape)

    def depth(self, index: int) -> NDArray[np.float32]:
        """(h, w) [m] of a frame, NaN where missing. Raises RecordingError."""
        depth = counts_to_metres(self.counts(index), DEPTH_SCALE)
        return sure(depth, self.confidence(index) if self.confident.used else None)

    def noisier(self, index: int) -> NDArray[np.float32] | None:
        """As of a `Frame`. Raises RecordingError."""
        if not self.confident.used or self.confident.middle == 1:
            return None
        return noisier(self.confidence(index), self.confident.middle)

    def confidence(self, index: int) -> NDArray[np.uint8] | None:
        """(h, w) 0, 127 or 255 (older: 0 to 2), or None where there is none. Raises RecordingError."""
        name = f"{KEYFRAMES}/confidence/{self.names[index]}.png"
        if not self.tree.has(name):
            return None
        image = grey_in(*self._file(name))
        return image if image.shape == self.shape else None

    def color(self, index: int) -> NDArray[np.uint8] | None:
        """(h, w, 3) RGB, or None where there is none. Raises RecordingError."""
        name = self.picture(index)
        return color_in(*self._file(name), self.wanted) if self.tree.has(name) else None

    def picture(self, index: int) -> str:
        """The name of a frame's colour image."""
        return f"{KEYFRAMES}/{self.pictures}/{self.names[index]}.jpg"

    def _file(self, name: str) -> tuple[bytes, Path]:
        return self.tree.read(name, "an image"), self.tree.where(name)


def recognises(path: Path) -> bool:
    """True for a folder or an archive with Polycam's key frames."""
    if not path.is_dir() and not is_zip(path):
        return False
    try:
        tree = open_tree(path, RecordingError, f"{KEYFRAMES}/")
        return bool(tree.names(f"{KEYFRAMES}/depth")) and bool(_camera_folder(tree))
    except RecordingError:
        return False


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in Polycam's raw data. Raises RecordingError."""
    tree = open_tree(path, RecordingError, f"{KEYFRAMES}/")
    folder = _camera_folder(tree)
    corrected = folder.startswith("corrected")
    with_depth = {name.removesuffix(".png") for name in tree.names(f"{KEYFRAMES}/depth")}
    cameras = tree.names(f"{KEYFRAMES}/{folder}")
    listed = [name.removesuffix(".json") for name in cameras if name.removesuffix(".json") in with_depth]
    names = sorted((name for name in listed if name.isascii() and name.isdigit() and len(name) < 19), key=int)
    if not names:
        raise RecordingError("the recording is empty", path, "no frame with depth and a camera", "one or more")
    first = f"{KEYFRAMES}/depth/{names[0]}.png"
    width, height = size_in(tree.read(first, "an image"), tree.where(first))
    pictures = "corrected_images" if corrected else "images"
    images = PolycamImages(tree, names, pictures, (height, width))
    images = replace(images, confident=confidence_of(images, len(names)))
    warnings = list(images.confident.told)
    given = [_keyframe(tree, f"{KEYFRAMES}/{folder}/{name}.json") for name in names]
    seen = _cameras(given, images) if camera is None else Cameras(sized(camera, images.shape), {})
    images = replace(images, wanted=seen.wanted)
    warnings += seen.told
    camera = replace(seen.camera, depth_scale=DEPTH_SCALE)
    stamps = np.array([int(name) for name in names]) * 1e-6
    source = ImageSource(
        path=path,
        camera=camera,
        stamps=stamps,
        depth=images.depth,
        noisier=images.noisier,
        color=images.color,
        has_color=np.array([tree.has(images.picture(i)) for i in range(len(names))]),
        own=seen.own,
        turn=seen.pictures,
        stored=seen.stored,
        counts=images.counts,
    )
    warnings += [] if corrected else ["poses are those of the phone's tracking: Polycam has not corrected them"]
    lost = len(with_depth) - len(names)
    warnings += [f"{lost} of {len(with_depth)} depth images have no camera: left out"] if lost else []
    warnings += [COARSE] * (max(width, height) <= LIDAR[0])
    poses, more = seen.poses(_poses(given, stamps, tree), images.depth)
    return source.recording("polycam", poses, warnings + more)


def _camera_folder(tree: Tree) -> str:
    """The cameras that Polycam has corrected where there are such, else those of the phone; "" for none."""
    folders = ("corrected_cameras", "cameras")
    held = (folder for folder in folders if any(n.endswith(".json") for n in tree.names(f"{KEYFRAMES}/{folder}")))
    return next(held, "")


def _keyframe(tree: Tree, name: str) -> PolycamCamera:
    where = tree.where(name)
    try:
        text = decoded(tree.read(name, "a camera"))
    except ValueError as problem:
        raise RecordingError("a camera is not text", where, problem, "JSON") from problem
    content = Content(json_in(text, where, RecordingError, "a camera"), where, "the camera", RecordingError)
    return content.as_type(PolycamCamera)


def _cameras(given: list[PolycamCamera], images: PolycamImages) -> Cameras:
    """The cameras that are stated, of the depth images."""
    size = int(given[0].width), int(given[0].height)
    stated = np.array([[k.fx, k.fy, k.cx, k.cy] for k in given])
    scale = np.array(size) / np.array([[k.width, k.height] for k in given])
    return cameras_of(stated * np.hstack([scale, scale]), size, images, map(images.picture, range(len(given))))


def _poses(given: list[PolycamCamera], stamps: NDArray[np.float64], tree: Tree) -> Trajectory:
    numbers = [
        [k.t_00, k.t_01, k.t_02, k.t_03, k.t_10, k.t_11, k.t_12, k.t_13, k.t_20, k.t_21, k.t_22, k.t_23] for k in given
    ]
    stated = np.array(numbers).reshape(-1, 3, 4)
    poses = from_arkit(stated[..., :3], stated[..., 3])
    # 0.01: as of other files that are written with few decimals
    if not all(is_rigid(T_world_camera, 0.01) for T_world_camera in poses):
        raise RecordingError("a pose is not rigid", tree.path, "t_00 to t_23", "a rotation and metres")
    return Trajectory(stamps, poses)
