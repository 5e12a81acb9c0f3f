"""Record3D's `.r3d`: a zip archive with `metadata` and, a frame, `rgbd/0.depth`, `0.conf`, `0.jpg`.

The app's author on the format: github.com/marek-simonik/record3d, issues 27, 31, 36, 64, 83, 86, 93.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M, Content
from fusion.files.json_file import json_in
from fusion.files.limits import check_size
from fusion.files.reading import decoded
from fusion.files.tree import Tree, is_zip, open_tree
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
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
from fusion.recording.formats.phones.lzfse import unpack
from fusion.recording.formats.recorded.parts import even_or_stated
from fusion.recording.images.read import color_in
from fusion.recording.native.camera_file import Size, are_focal
from fusion.recording.native.text_files import LATEST
from fusion.recording.recording import Recording
from fusion.recording.streamed import REAL_SCALE, ImageSource

Number = Annotated[float, Meta(gt=-1e7, lt=1e7)]
Four = Annotated[list[Number], Meta(min_length=4, description="fx, fy, tx, ty [px]")]
Seven = Annotated[list[Number], Meta(min_length=7, max_length=7, description="qx, qy, qz, qw, tx, ty, tz")]
Stamp = Annotated[float, Meta(gt=-LATEST, lt=LATEST, description="seconds")]
Nine = Annotated[list[Number], Meta(min_length=9, max_length=9, description="9 numbers, column by column [px]")]


class Metadata(Struct, frozen=True, kw_only=True):
    """What is used of a recording's `metadata`."""

    w: Size
    h: Size
    K: Nine
    dw: Size | None = None
    dh: Size | None = None
    fps: Annotated[float, Meta(gt=0, le=1e4, description="frames a second")] = 30.0
    perFrameIntrinsicCoeffs: list[Four] = []
    frameTimestamps: list[Stamp] = []
    poses: list[Seven] = []


@dataclass(frozen=True)
class Record3dImages:
    """The images of a recording."""

    tree: Tree  # the archive
    numbers: list[int]  # of the frames, as their files are named
    shape: tuple[int, int]  # (height, width) of the depth images
    confident: Confidence = UNKNOWN  # what confidence is worth
    # (height, width) that colour images are turned to where their notes (EXIF) ask for it; None: never
    wanted: tuple[int, int] | None = None

    def depth(self, index: int) -> NDArray[np.float32]:
        """(h, w) [m] of a frame, NaN where missing. Raises RecordingError."""
        name = f"rgbd/{self.numbers[index]}.depth"
        size = 4 * self.shape[0] * self.shape[1]
        data = unpack(self.tree.read(name, "a depth image"), size, self.tree.where(name))
        depth = np.frombuffer(data, "<f4").reshape(self.shape)
        return sure(depth, self.confidence(index) if self.confident.used else None)

    def noisier(self, index: int) -> NDArray[np.float32] | None:
        """As of a `Frame`. Raises RecordingError."""
        if not self.confident.used or self.confident.middle == 1:
            return None
        return noisier(self.confidence(index), self.confident.middle)

    def confidence(self, index: int) -> NDArray[np.uint8] | None:
        """(h, w) 0 to 2, or None where there is none. Raises RecordingError."""
        name = f"rgbd/{self.numbers[index]}.conf"
        if not self.tree.has(name):
            return None
        size = self.shape[0] * self.shape[1]
        data = unpack(self.tree.read(name, "a confidence image"), size, self.tree.where(name))
        return np.frombuffer(data, np.uint8).reshape(self.shape)

    def color(self, index: int) -> NDArray[np.uint8] | None:
        """(h, w, 3) RGB, or None where there is none. Raises RecordingError."""
        name = f"rgbd/{self.numbers[index]}.jpg"
        return (
            color_in(self.tree.read(name, "an image"), self.tree.where(name), self.wanted)
            if self.tree.has(name)
            else None
        )


def recognises(path: Path) -> bool:
    """True for an archive, or what was unpacked of one, with Record3D's metadata beside its images."""
    if not path.is_dir() and not is_zip(path):
        return False
    try:
        tree = open_tree(path, RecordingError, "metadata")
        return tree.has("metadata") and any(name.endswith(".depth") for name in tree.names("rgbd"))
    except RecordingError:
        return False


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in a `.r3d` file, or in what was unpacked of one. Raises RecordingError."""
    tree = open_tree(path, RecordingError, "metadata")
    content = _metadata(tree)
    given = content.as_type(Metadata)
    names = [name.removesuffix(".depth") for name in tree.names("rgbd") if name.endswith(".depth")]
    numbers = sorted(int(name) for name in names if name.isascii() and name.isdigit() and len(name) < 10)
    if not numbers:
        raise RecordingError("the recording is empty", path, "no frame with depth", "rgbd/0.depth and so on")
    shape = _depth_shape(given, tree, f"rgbd/{numbers[0]}.depth")
    images = Record3dImages(tree, numbers, shape)
    images = replace(images, confident=confidence_of(images, len(numbers)))
    warnings = list(images.confident.told)
    seen = _cameras(given, content, images) if camera is None else Cameras(sized(camera, shape), {})
    images = replace(images, wanted=seen.wanted)
    warnings += seen.told
    camera = replace(seen.camera, depth_scale=REAL_SCALE)
    stamps, more = _stamps(given, numbers)
    source = ImageSource(
        path=path,
        camera=camera,
        stamps=stamps,
        depth=images.depth,
        noisier=images.noisier,
        color=images.color,
        has_color=np.array([tree.has(f"rgbd/{number}.jpg") for number in numbers]),
        own=seen.own,
        turn=seen.pictures,
        stored=seen.stored,
    )
    warnings += more + [COARSE] * (max(shape) <= LIDAR[0])
    poses, more = seen.poses(_poses(given, numbers, stamps, content), images.depth)
    return source.recording("record3d", poses, warnings + more)


def _metadata(tree: Tree) -> Content:
    where = tree.where("metadata")
    try:
        text = decoded(tree.read("metadata", "the metadata"))
    except ValueError as problem:
        raise RecordingError("the metadata is not text", where, problem, "JSON") from problem
    return Content(json_in(text, where, RecordingError, "the metadata"), where, "the recording", RecordingError)


def _depth_shape(given: Metadata, tree: Tree, first: str) -> tuple[int, int]:
    """(height, width) of the depth images as they are stated, else as the colour's shape and their bytes tell."""
    if given.dw is not None and given.dh is not None:
        shape = int(given.dh), int(given.dw)
        check_size(64 * shape[0] * shape[1], tree.path, RecordingError, f"a frame of {shape[1]} x {shape[0]} pixels")
        return shape
    for short in (192, 480, 360, 720):  # the sizes that phones have given
        width = short if given.w < given.h else round(short * given.w / given.h)
        height = short if given.w >= given.h else round(short * given.h / given.w)
        try:
            unpack(tree.read(first, "a depth image"), 4 * width * height, tree.where(first))
        except RecordingError:
            continue
        return height, width
    raise RecordingError("the size of the depth images is not known", tree.where("metadata"), "no dw, dh", "both")


def _cameras(given: Metadata, content: Content, images: Record3dImages) -> Cameras:
    """The cameras that are stated, of the depth images."""
    K = given.K
    stated = np.array([given.perFrameIntrinsicCoeffs[n][:4] for n in images.numbers
                       if n < len(given.perFrameIntrinsicCoeffs)])  # fmt: skip
    if len(stated) != len(images.numbers):
        stated = np.array([[K[0], K[4], K[6], K[7]]] * len(images.numbers))
    if not all(are_focal(fx, fy) for fx, fy in stated[:, :2].tolist()):
        raise content.wrong(Metadata, "perFrameIntrinsicCoeffs" if given.perFrameIntrinsicCoeffs else "K")
    # 3: as many images are looked for as may be missing at the begin
    names = (f"rgbd/{number}.jpg" for number in images.numbers[:3])
    return cameras_of(stated, (int(given.w), int(given.h)), images, names)


def _stamps(given: Metadata, numbers: list[int]) -> tuple[NDArray[np.float64], list[str]]:
    times = given.frameTimestamps
    if numbers[-1] < len(times):
        return even_or_stated(np.array([times[number] for number in numbers]), given.fps)
    told = f"time stamps are missing: frames are taken for {given.fps:g} a second"
    return np.array(numbers) / given.fps, [told]


def _poses(given: Metadata, numbers: list[int], stamps: Array, content: Content) -> Trajectory | None:
    """Camera to world in ARKit's axes; videos of the front camera have none."""
    from scipy.spatial.transform import Rotation

    poses = np.full((len(numbers), 4, 4), np.nan)
    there = np.flatnonzero(np.array(numbers) < len(given.poses))
    stated = np.array([given.poses[numbers[i]] for i in there]).reshape(-1, 7)
    length = np.linalg.norm(stated[:, :4], axis=1)
    # 0.05: as of TUM's files; another order of the numbers is not taken for a rotation. 0: tracking was lost
    wrong = (length > 0) & ((np.abs(length - 1) > 0.05) | (np.abs(stated[:, 4:]).max(axis=1, initial=0) > FARTHEST_M))
    if wrong.any():
        at = numbers[int(there[wrong.argmax()])]
        raise content.wrong(Metadata, "poses", at, expected="a quaternion of unit length, then metres")
    tracked = length > 0
    if tracked.any():
        poses[there[tracked]] = from_arkit(Rotation.from_quat(stated[tracked, :4]).as_matrix(), stated[tracked, 4:])
    known = np.isfinite(poses).all(axis=(1, 2))
    # all the same: no tracking was on
    if known.sum() < 2 or np.ptp(poses[known], axis=0).max() == 0:
        return None
    return Trajectory(stamps, poses)
