"""Bags as recordings: which kind of file, whose streams, which of several depth streams."""

import re
from pathlib import Path
from types import ModuleType

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.geometry.camera import Camera
from fusion.recording.formats.bags import orbbec, realsense, ros
from fusion.recording.formats.bags.containers import mcap, rosbag1, sqlite_bag
from fusion.recording.formats.bags.containers.store import Store, joined
from fusion.recording.formats.bags.streams import ChosenStreams, recording_of
from fusion.recording.recording import Recording

HAS_TOPICS = True
KINDS = (rosbag1, sqlite_bag, mcap)
LISTED = 8  # topics in a message


def recognises(path: Path) -> bool:
    """True for a bag's file, and for a folder of ROS 2 with `metadata.yaml` beside such files."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file() and any(_kind(part) for part in _parts(path))
    return _kind(path) is not None


def read(path: Path, camera: Camera | None, topic: str | None = None) -> Recording:
    """The recording in a bag.

    Args:
        path: the file, or ROS 2's folder.
        camera: instead of the bag's own.
        topic: the depth stream, where there are several.

    Raises:
        RecordingError: the bag is damaged, holds no depth that can be read, several depth streams of which none is
            named, or no camera.
    """
    store = _store(path)
    for maker in (realsense, orbbec):
        names = maker.depth_topics(store)
        if names:
            name = _one(names, topic, path, store)
            return recording_of(path, maker.choose(store, name, camera))
    images = ros.images_of(store)
    name = _one(ros.depth_topics(images), topic, path, store)
    chosen: ChosenStreams = ros.choose(store, images, name, camera)
    return recording_of(path, chosen)


def _store(path: Path) -> Store:
    if not path.is_dir():
        return _read(path)
    return joined(path, [_read(part) for part in _parts(path) if _kind(part)])


def _read(path: Path) -> Store:
    kind = _kind(path)
    assert kind is not None
    store: Store = kind.read(path)
    return store


def _kind(path: Path) -> ModuleType | None:
    return next((kind for kind in KINDS if kind.recognises(path)), None)


def _parts(folder: Path) -> list[Path]:
    """Files of a folder in the order in which a recorder numbers them: name_2 before name_10."""
    names = sorted(
        (entry.name for entry in folder.iterdir() if entry.suffix in (".db3", ".mcap")),
        key=lambda name: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)],
    )
    return [folder / name for name in all_inside(folder, names, RecordingError)]


def _one(names: list[str], topic: str | None, path: Path, store: Store) -> str:
    """The depth stream that is meant. Raises RecordingError."""
    listed = ", ".join(names[:LISTED]) + f" and {len(names) - LISTED} more" * (len(names) > LISTED)
    if topic is not None:
        if topic in names:
            return topic
        near = [name for name in names if topic.strip("/") in name]
        if len(near) == 1:
            return near[0]
        raise RecordingError("there is no such depth stream", path, topic, listed or "one with depth images")
    if not names:
        held = ", ".join(sorted(store.topics)[:LISTED]) or "no messages"
        raise RecordingError("the bag holds no depth images", path, held, "16UC1, 32FC1 or compressedDepth images")
    if len(names) > 1:
        raise RecordingError("the bag holds several depth streams", path, listed, "one", "choose one with --topic")
    return names[0]
