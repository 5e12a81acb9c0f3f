"""Definitions of message types: text of ROS as fields, and the types that a bag may use without defining them."""

import re
from dataclasses import dataclass
from functools import cache

import numpy as np

NUMBERS = {
    "bool": "u1", "byte": "u1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
ANY = -1  # length of an array that tells it itself
_LINE = re.compile(r"^(?P<type>[\w/]+)(?:<=\d+)?(?P<array>\[[^\]]*\])?\s+(?P<name>\w+)\s*(?P<rest>.*)$")


@dataclass(frozen=True)
class Field:
    """A field of a type: `count` None for one value, ANY or a fixed number for an array of them."""

    name: str
    type: str
    count: int | None


Types = dict[str, tuple[Field, ...]]

# common_interfaces and geometry2 of ROS 2; where ROS 1 differs, {} is filled
_TEXTS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/String": "string data",
    "std_msgs/Float32": "float32 data",
    "diagnostic_msgs/KeyValue": "string key\nstring value",
    "sensor_msgs/RegionOfInterest": "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify",
    "sensor_msgs/Image": "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
    "uint32 step\nuint8[] data",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "sensor_msgs/CameraInfo": "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
    "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
    "sensor_msgs/RegionOfInterest roi",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "tf/tfMessage": "geometry_msgs/TransformStamped[] transforms",
}
_HEADER = {
    False: "uint32 seq\ntime stamp\nstring frame_id",
    True: "builtin_interfaces/Time stamp\nstring frame_id",
}


@cache
def built_in(ros2: bool) -> Types:
    """The types known without a definition."""
    texts = {**_TEXTS, "std_msgs/Header": _HEADER[ros2]}
    return {name: _fields(text, name.partition("/")[0]) for name, text in texts.items()}


def built_in_text(name: str) -> str:
    """The text of a built-in type, as ROS 2 has it."""
    return {**_TEXTS, "std_msgs/Header": _HEADER[True]}[name]


@cache
def types_of(name: str, definition: str, ros2: bool) -> Types:
    """The built-in types with those of a message's definition: its own text, then `MSG: name` and text of each inside.

    Raises:
        ValueError: a line that cannot be read.
    """
    types = dict(built_in(ros2))
    if not definition.strip():
        return types
    for part, text in enumerate(re.split(r"^=+\s*$", definition, flags=re.MULTILINE)):
        called = name
        if part:
            first, _, text = text.strip("\n").partition("\n")
            if not first.startswith("MSG:"):
                continue
            called = first.removeprefix("MSG:").strip().replace("/msg/", "/")
        types[called] = _checked(called, _fields(text, called.partition("/")[0]), ros2)
    return types


def _checked(name: str, fields: tuple[Field, ...], ros2: bool) -> tuple[Field, ...]:
    """The fields of a type, which may have more than the built-in type of this name, but none of another kind."""
    missing = set(built_in(ros2).get(name, ())) - set(fields)
    if missing:
        raise ValueError(f"a definition of {name} without {', '.join(sorted(one.name for one in missing))}")
    return fields


def _fields(text: str, package: str) -> tuple[Field, ...]:
    fields = []
    for line in text.splitlines():
        plain = line.partition("#")[0].strip()
        found = _LINE.match(plain)
        if not plain or plain.startswith("MSG:"):
            continue
        if not found:
            raise ValueError(f"a definition with the line {plain[:60]!r}")
        if found["rest"].startswith("=") and not found["rest"].startswith("=="):
            continue  # a constant takes no bytes
        fields.append(Field(found["name"].lower(), _full(found["type"], package), _count(found["array"])))
    return tuple(fields)


def _full(name: str, package: str) -> str:
    if name in NUMBERS or name in ("string", "wstring", "time", "duration"):
        return name
    name = name.replace("/msg/", "/")
    return name if "/" in name else "std_msgs/Header" if name == "Header" else f"{package}/{name}"


def _count(array: str | None) -> int | None:
    if array is None:
        return None
    inside = array[1:-1].strip()
    return int(inside) if inside.isdigit() else ANY


def dtype(name: str, big: bool) -> np.dtype | None:
    """How a number of this type lies in a message, None for what is no number."""
    code = NUMBERS.get(name)
    return None if code is None else np.dtype((">" if big else "<") + code)
