"""Messages of ROS 2 as bytes, and the text of their definitions: what is written into bags."""

import struct
from typing import Any

import numpy as np

from fusion.recording.formats.bags.messages.definitions import ANY, Field, built_in, built_in_text, dtype
from fusion.recording.formats.bags.messages.values import RosValues

HEAD = b"\0\1\0\0"  # plain CDR, little endian


def encoded(name: str, values: RosValues) -> bytes:
    """A message of a built-in type; `values` by field name, all of them."""
    out = bytearray(HEAD)
    _put_struct(out, name, values)
    return bytes(out)


def definition_text(name: str) -> str:
    """A type's definition with those of the types inside it, as ROS 2's recorder stores them (ros2msg)."""
    parts, seen = [built_in_text(name)], {name}
    waiting = list(built_in(True)[name])
    while waiting:
        inner = waiting.pop(0).type
        if inner in built_in(True) and inner not in seen:
            seen.add(inner)
            parts.append(f"MSG: {inner}\n{built_in_text(inner)}")
            waiting += built_in(True)[inner]
    return f"\n{'=' * 80}\n".join(parts)


def long_type(name: str) -> str:
    """ROS 1's "sensor_msgs/Image" as ROS 2's "sensor_msgs/msg/Image"."""
    return name.replace("/", "/msg/", 1)


def _put_struct(out: bytearray, name: str, values: RosValues) -> None:
    for field in built_in(True)[name]:
        _put(out, field, values[field.name])


def _put(out: bytearray, field: Field, value: Any) -> None:
    kind = dtype(field.type, big=False)
    if field.count is None:
        if kind is not None:
            _align(out, kind.itemsize)
            out += np.asarray(value, kind).tobytes()
        elif field.type == "string":
            data = str(value).encode() + b"\0"
            _align(out, 4)
            out += struct.pack("<I", len(data)) + data
        else:
            _put_struct(out, field.type, value)
        return
    if field.count == ANY:
        _align(out, 4)
        out += struct.pack("<I", len(value))
    if kind is None:
        for one in value:
            _put_struct(out, field.type, one)
    elif len(value):
        _align(out, kind.itemsize)
        out += np.ascontiguousarray(value, kind).tobytes()


def _align(out: bytearray, size: int) -> None:
    out += b"\0" * (-(len(out) - len(HEAD)) % size)
