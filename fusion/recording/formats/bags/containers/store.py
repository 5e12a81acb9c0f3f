"""Messages in a file, whatever kind of bag it is: topics, an index that is read at once, and bytes that are not."""

import os
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular

DO = "copy the file again, or record it anew"
MOST_MESSAGES = 50_000_000  # of all topics: the index takes 24 bytes for each


@dataclass(frozen=True)
class Topic:
    """A stream of messages of one type."""

    name: str  # such as "/camera/depth/image_raw"
    type: str  # "sensor_msgs/Image", without ROS 2's "/msg"
    stamps: NDArray[np.int64]  # (n,) when each was recorded [ns], never falling
    # bytes of one message from its start, all of them or the first `most`; raises RecordingError
    read: Callable[[int, int], bytes]
    definition: str = ""  # the type's definition as the file holds it, "" where it holds none
    ros2: bool = True  # messages are CDR; else ROS 1's own packing
    packed: bool = False  # to get at the start of one message others must be unpacked
    steps_back: int = 0  # how many messages have an earlier stamp than the one before them in the file

    def __len__(self) -> int:
        return len(self.stamps)


@dataclass(frozen=True)
class Store:
    """A bag."""

    path: Path  # the file or folder
    topics: dict[str, Topic]  # by name, those without a message left out
    warnings: tuple[str, ...] = ()  # what was wrong with the file, one sentence each


class BagFile:
    """A bag's file, open until nobody holds it: any thread may read, at any place."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open_regular(path, RecordingError, "the bag", takes=0)
        self.size = os.fstat(self._file.fileno()).st_size
        weakref.finalize(self, self._file.close)

    def read(self, at: int, count: int, what: str = "a part of the bag") -> bytes:
        """Exactly `count` bytes from byte `at`. Raises RecordingError where the file ends before, or for size."""
        check_size(count, self.path, RecordingError, what)
        if 0 <= at <= at + count <= self.size:
            data = os.pread(self._file.fileno(), count, at)
            if len(data) == count:
                return data
        raise cut(self.path, f"{what} of {count} bytes at byte {at} of {self.size}")


def cut(path: Path, found: object) -> RecordingError:
    """The bag ends before its content does, or its content leads out of it."""
    return RecordingError("the bag is damaged or cut off", path, found, "a whole bag", DO)


def joined(path: Path, stores: Sequence[Store]) -> Store:
    """Bags that continue each other (a recorder splits long ones), as one."""
    if len(stores) == 1:
        return Store(path, stores[0].topics, stores[0].warnings)
    names = dict.fromkeys(name for store in stores for name in store.topics)
    topics = {name: _joined([store.topics[name] for store in stores if name in store.topics]) for name in names}
    return Store(path, topics, tuple(dict.fromkeys(text for store in stores for text in store.warnings)))


def _joined(parts: list[Topic]) -> Topic:
    parts = sorted(parts, key=lambda part: int(part.stamps[0]))
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *map(len, parts)])

    def read(index: int, most: int) -> bytes:
        which = int(np.searchsorted(starts, index, side="right")) - 1
        return parts[which].read(index - int(starts[which]), most)

    first = parts[0]
    stamps = np.concatenate([part.stamps for part in parts])
    packed, back = any(part.packed for part in parts), sum(part.steps_back for part in parts)
    return Topic(first.name, first.type, stamps, read, first.definition, first.ros2, packed, back)


def falls(stamps: NDArray[np.int64], *places: NDArray) -> int:
    """How many of the stamps (n,) are earlier than the one before, in the order of their places in the file.

    Args:
        stamps: in any order.
        places: (n,) each, what counts most first: the chunk, the byte in it.
    """
    return int((np.diff(stamps[np.lexsort(places[::-1])]) < 0).sum())


def short_type(name: str) -> str:
    """ROS 2's "sensor_msgs/msg/Image" as ROS 1's "sensor_msgs/Image"."""
    return name.replace("/msg/", "/")
