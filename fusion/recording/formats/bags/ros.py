"""Bags of ROS drivers: which topic is the depth, which camera took it, and what lies beside it.

REP 118: depth is 16UC1 in millimetres or 32FC1 in metres. An image's `camera_info` stands beside it; where the image is
rectified (its name says so) P is its camera and its lens is taken out.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import PurePosixPath

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.json_file import json_in
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.lens import camera_of_info
from fusion.recording.cameras.presets import say_camera
from fusion.recording.formats.bags.containers.store import Store, Topic
from fusion.recording.formats.bags.messages.values import frame_of, message
from fusion.recording.formats.bags.pictures import COMPRESSED, IMAGE, FirstImage, look_at
from fusion.recording.formats.bags.streams import METRES_SCALE, BagStream, ChosenStreams, stream_stamps
from fusion.recording.formats.bags.transforms import Tree, between, poses_at, read_tree, stated_poses
from fusion.recording.native.camera_file import camera_content, camera_of
from fusion.recording.native.device_file import settings_in
from fusion.recording.native.scene_file import scene_in
from fusion.recording.native.telemetry_file import telemetry_in

INFO = "sensor_msgs/CameraInfo"
# in bags that this program wrote, what messages of ROS cannot say: unit, sensor, what was logged, what stood there
CAMERA_TOPIC, TELEMETRY_TOPIC, SCENE_TOPIC = "/fusion/camera_json", "/fusion/telemetry_csv", "/fusion/scene_json"
DEVICE_TOPIC = "/fusion/device_json"
INFRARED = ("ir", "infra", "infra1", "infra2", "infrared", "amplitude", "confidence")
MILLIMETRES = 1000.0


@dataclass(frozen=True)
class ImageTopic:
    """A topic of images: how its first one looks, in which frame, and its name without the way it is packed."""

    topic: Topic
    look: FirstImage
    frame: str
    base: str

    @property
    def infrared(self) -> bool:
        """True where the name says that it is no depth and no colour."""
        words = {word for part in self.base.lower().split("/") for word in part.split("_")}
        return bool(words & set(INFRARED)) and "depth" not in words


def images_of(store: Store) -> list[ImageTopic]:
    """The topics of images that can be read; of one image packed in several ways the one with the most messages."""
    found: dict[str, ImageTopic] = {}
    for name, topic in sorted(store.topics.items()):
        if topic.type not in (IMAGE, COMPRESSED):
            continue
        try:
            look, frame = look_at(topic), frame_of(topic)
        except RecordingError as problem:
            if isinstance(problem.__cause__, ImportError):  # of a bag that is packed none can be read without it
                raise
            continue  # theora and the like: another may be readable
        base = name
        for ending in ("/compressedDepth", "/compressed"):
            base = base.removesuffix(ending)
        if base not in found or len(found[base].topic) < len(topic):
            found[base] = ImageTopic(topic, look, frame.lstrip("/"), base)
    return list(found.values())


def depth_topics(images: list[ImageTopic]) -> list[str]:
    """Names of those that hold depth: 16 or 32 bit, and not called infrared; mono16 only where it is called depth."""
    return [
        one.topic.name
        for one in images
        if one.look.kind == "depth"
        and not one.infrared
        and (one.look.encoding in ("16uc1", "32fc1", "z16") or "depth" in one.base.lower())
    ]


def choose(store: Store, images: list[ImageTopic], name: str, camera: Camera | None) -> ChosenStreams:
    """Depth by the name of its topic, with colour, infrared and poses as the bag has them. Raises RecordingError."""
    warnings = list(store.warnings)
    depth = next(one for one in images if one.topic.name == name)
    own = _own_camera(store, depth)
    stated = camera or own or _camera(store, depth)
    if stated is None:
        do = say_camera("realsense-d435")
        raise RecordingError("the recording has no camera", store.path, f"no camera_info beside {name}", do=do)
    if camera is None:
        scale = own.depth_scale if own is not None else METRES_SCALE
        stated = replace(stated, depth_scale=scale if depth.look.metres else MILLIMETRES)
    elif not depth.look.metres and camera.depth_scale != MILLIMETRES:
        warnings.append(f"the depth is taken for {camera.depth_scale:g} counts a metre, as --camera says, not for mm")
    tree = read_tree(store)
    stream = _stream(depth, stated, warnings)
    first = float(stream.stamps.min())
    color = _color(images, depth, tree, first)
    T = between(tree, depth.frame, color.frame, first) if color is not None else None
    settings = _own_settings(store, warnings)
    return ChosenStreams(
        "ros2" if depth.topic.ros2 else "ros1",
        stream,
        None if color is None else _stream(color, _camera_or_told(store, color, warnings), warnings),
        _infrared(images, depth, warnings),
        depth.look.metres,
        T,
        color is not None and _same_pixels(color, depth),
        telemetry_in(logged, store.path, warnings) if (logged := _own_text(store, TELEMETRY_TOPIC)) else {},
        scene_in(stated_scene, store.path) if (stated_scene := _own_text(store, SCENE_TOPIC)) else {},
        partial(_poses, store, tree, depth.frame),
        tuple(warnings),
        settings,
    )


def _own_camera(store: Store, depth: ImageTopic) -> Camera | None:
    """The camera that this program wrote beside CameraInfo, with what that cannot say. Raises RecordingError."""
    text = _own_text(store, CAMERA_TOPIC)
    if not text:
        return None
    camera = camera_of(camera_content(json_in(text, CAMERA_TOPIC, RecordingError), CAMERA_TOPIC))
    return camera if camera.shape == (depth.look.height, depth.look.width) else None


def _own_settings(store: Store, warnings: list[str]) -> dict[str, str]:
    text = _own_text(store, DEVICE_TOPIC)
    try:
        return settings_in(json_in(text, DEVICE_TOPIC, RecordingError)) if text else {}
    except RecordingError as problem:  # no frame needs it
        warnings.append(f"{DEVICE_TOPIC} is left out: {problem}")
        return {}


def _own_text(store: Store, name: str) -> str:
    topic = store.topics.get(name)
    return str(message(topic, 0)["data"]) if topic is not None and topic.type == "std_msgs/String" else ""


def _poses(store: Store, tree: Tree, frame: str, stamps: NDArray[np.float64]) -> Trajectory | None:
    """Of this program's own bags those that were written: a frame without one was lost, and is not put in between."""
    return stated_poses(tree, frame) if CAMERA_TOPIC in store.topics else poses_at(tree, frame, stamps)


def _stream(images: ImageTopic, camera: Camera | None, warnings: list[str]) -> BagStream:
    size = len(images.topic.read(0, -1))
    return BagStream(images.topic, stream_stamps(images.topic, size, warnings), camera)


def _camera(store: Store, images: ImageTopic) -> Camera | None:
    """By the CameraInfo beside the images, else by the only one of their frame and size. Raises RecordingError."""
    beside = str(PurePosixPath(images.base).parent / "camera_info")
    found = [store.topics[name] for name in (beside, f"{images.base}/camera_info") if name in store.topics]
    found = [topic for topic in found if topic.type == INFO]
    if not found:
        infos = [topic for topic in store.topics.values() if topic.type == INFO]
        found = [topic for topic in infos if frame_of(topic).lstrip("/") == images.frame != "" and _fits(topic, images)]
        found = found if len(found) == 1 else []
    if not found:
        return None
    camera = camera_of_info(message(found[0], 0), found[0].name, "rect" in images.base.lower())
    if camera.shape != (images.look.height, images.look.width):
        size = f"{images.look.width} x {images.look.height}"
        found_size = f"{camera.width} x {camera.height}"
        raise RecordingError("the camera is of another size than its images", found[0].name, found_size, size)
    return camera


def _fits(topic: Topic, images: ImageTopic) -> bool:
    values = message(topic, 0)
    return (values.get("width"), values.get("height")) == (images.look.width, images.look.height)


def _camera_or_told(store: Store, images: ImageTopic, warnings: list[str]) -> Camera | None:
    try:
        return _camera(store, images)
    except RecordingError as problem:
        warnings.append(f"{images.topic.name}: {problem}")
        return None


def _same_pixels(one: ImageTopic, depth: ImageTopic) -> bool:
    """Images of one frame and one size are of one camera, or registered to it."""
    size = (one.look.width, one.look.height)
    return one.frame == depth.frame != "" and size == (depth.look.width, depth.look.height)


def _color(images: list[ImageTopic], depth: ImageTopic, tree: Tree, stamp: float) -> ImageTopic | None:
    """The best colour topic: in the depth's pixels, else of a camera whose place is known, else any."""

    def rank(one: ImageTopic) -> tuple:
        known = between(tree, depth.frame, one.frame, stamp) is not None
        name = one.base.lower()
        return _same_pixels(one, depth), known, "color" in name or "rgb" in name, len(one.topic)

    able = [one for one in images if one.look.kind == "color" and not one.infrared]
    return max(able, key=rank, default=None)


def _infrared(images: list[ImageTopic], depth: ImageTopic, warnings: list[str]) -> BagStream | None:
    """Grey images in the depth camera's pixels."""
    able = [one for one in images if one.look.kind in ("grey", "depth") and one.infrared and _same_pixels(one, depth)]
    return _stream(able[0], None, warnings) if able else None
