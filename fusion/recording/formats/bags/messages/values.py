"""A message's bytes as values by the names of its fields: CDR of ROS 2, and ROS 1's packing."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fusion.errors import RecordingError
from fusion.recording.formats.bags.containers.store import Topic, cut
from fusion.recording.formats.bags.messages.definitions import ANY, Field, Types, built_in, dtype, types_of

DEEPEST = 16  # types in types
MOST_VALUES = 200_000  # in one message; arrays of numbers count as one
CDR_HEAD = 4  # bytes before a CDR message: its byte order, from which alignment counts


class RosValues(dict[str, Any]):
    """Values of a ROS message, or of a part of one, by field name in small letters; arrays of numbers as arrays."""


@dataclass(frozen=True)
class Message:
    """A message, and the bytes behind it."""

    values: RosValues
    rest: bytes


def decoded(topic: Topic, data: bytes) -> Message:
    """The message that these bytes of a topic hold.

    Raises:
        RecordingError: its type is not known, or the bytes do not fit it.
    """
    try:
        types = types_of(topic.type, topic.definition, topic.ros2)
        if topic.type not in types:
            raise ValueError(f"the type {topic.type}, which the bag does not define")
        # what a maker put behind the fields that all know is left as it is: not all tell it rightly
        known = built_in(topic.ros2).get(topic.type, ())
        if known and types[topic.type][: len(known)] == known:
            types = {**types, topic.type: known}
        reader = _MessageReader(data, topic.ros2)
        values = reader.struct(types, topic.type, 0)
        return Message(values, data[reader.at :])
    except ValueError as problem:
        raise RecordingError("a message cannot be read", topic.name, problem, topic.type) from problem


def message(topic: Topic, index: int) -> RosValues:
    """The values of one message of a topic. Raises RecordingError."""
    return decoded(topic, topic.read(index, -1)).values


def header_stamps(topic: Topic) -> tuple[np.ndarray, str]:
    """Stamps (n,) [ns] that the messages carry in their header, and the first one's frame. Raises RecordingError."""
    stamps = np.empty(len(topic), np.int64)
    head = CDR_HEAD + 8 if topic.ros2 else 12
    for index in range(len(topic)):
        data = topic.read(index, head)
        if len(data) < head:
            raise cut(Path(topic.name), f"message {index} of {len(data)} bytes")
        big = topic.ros2 and data[1] & 1 == 0
        order: Literal["big", "little"] = "big" if big else "little"
        seconds = int.from_bytes(data[4:8], order, signed=topic.ros2)
        stamps[index] = seconds * 1_000_000_000 + int.from_bytes(data[8:12], order)
    return stamps, frame_of(topic)


def frame_of(topic: Topic) -> str:
    """`frame_id` of a topic's first message, "" where it has none. Raises RecordingError."""
    reader = _MessageReader(topic.read(0, 300), topic.ros2)
    try:
        for _ in range(2 if topic.ros2 else 3):
            reader.number("uint32")
        return str(reader.string())
    except ValueError as problem:
        raise RecordingError("a message cannot be read", topic.name, problem, topic.type) from problem


class _MessageReader:
    """Goes through the bytes of one message."""

    def __init__(self, data: bytes, ros2: bool) -> None:
        self.data, self.ros2 = data, ros2
        self.at, self.left = 0, MOST_VALUES
        self.big = False
        if ros2:
            if len(data) < CDR_HEAD or data[0] != 0 or data[1] > 1:
                raise ValueError(f"a message that begins with {data[:4].hex()} (plain CDR: 0000 or 0001)")
            self.big, self.at = data[1] == 0, CDR_HEAD

    def take(self, count: int, align: int = 1) -> bytes:
        if self.ros2 and align > 1:
            self.at += -(self.at - CDR_HEAD) % align
        if count < 0 or self.at + count > len(self.data):
            raise ValueError(f"{len(self.data)} bytes where {self.at + count} are needed")
        self.at += count
        return self.data[self.at - count : self.at]

    def number(self, name: str) -> Any:
        kind = dtype(name, self.big)
        assert kind is not None
        return np.frombuffer(self.take(kind.itemsize, kind.itemsize), kind)[0].item()

    def string(self) -> str:
        text = self.take(self.number("uint32"))
        return text.removesuffix(b"\0").decode("utf-8", "replace") if self.ros2 else text.decode("utf-8", "replace")

    def struct(self, types: Types, name: str, depth: int) -> RosValues:
        if depth > DEEPEST or name not in types:
            raise ValueError(f"the type {name}, {'types in types without end' if depth > DEEPEST else 'not defined'}")
        return RosValues({field.name: self.field(types, field, depth) for field in types[name]})

    def field(self, types: Types, field: Field, depth: int) -> Any:
        if field.count is None:
            return self.one(types, field.type, depth)
        count = self.number("uint32") if field.count == ANY else field.count
        kind = dtype(field.type, self.big)
        if kind is not None:
            # an empty array is not padded to what it would hold
            data = self.take(count * kind.itemsize, kind.itemsize if count else 1)
            return np.frombuffer(data, kind)
        if count > self.left:
            raise ValueError(f"an array of {count} {field.type}")
        return [self.one(types, field.type, depth) for _ in range(count)]

    def one(self, types: Types, name: str, depth: int) -> Any:
        self.left -= 1
        if self.left < 0:
            raise ValueError(f"more than {MOST_VALUES} values")
        if dtype(name, self.big) is not None:
            return self.number(name)
        if name == "string":
            return self.string()
        if name in ("time", "duration"):
            return {"sec": self.number("uint32"), "nanosec": self.number("uint32")}
        return self.struct(types, name, depth + 1)
