"""OpenNI's `.oni`: records of nodes, their properties and their images; depth raw or packed by 16z.

Seen in files of OpenNI 2's own recorder. A record's head: "NIR", kind, node, bytes of head and fields, bytes of data.
"""

import struct
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import beginning, open_regular
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import say_camera
from fusion.recording.formats.recorded import sixteen_z
from fusion.recording.formats.recorded.parts import ByteRange, counts_of, even_or_stated, read_part
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

START = b"NI10"
BEGIN = 24  # bytes of the file's head
RECORD = struct.Struct("<4sIIIIQ")
MAGIC = b"NIR\0"
NODES, INTEGER, GENERAL, DATA, END = (0x02, 0x0C, 0x0D), 0x03, 0x06, 0x0A, 0x0B
DEPTH = 2  # kind of node
FIELDS = 4096  # bytes that the fields of a record may have; none comes near
TAKES = 300  # bytes in memory for each frame's place
TENTHS = 101  # OpenNI 2's pixel format of tenths of a millimetre; 100 is of millimetres
FRAMES_PER_SECOND = 30.0


@dataclass
class OniStream:
    """One stream of a file, as far as it is read."""

    kind: int
    codec: str
    properties: dict[str, bytes] = field(default_factory=dict)
    stamps: list[int] = field(default_factory=list)
    parts: list[ByteRange] = field(default_factory=list)

    def integer(self, name: str) -> int | None:
        """A property that is one number, or None."""
        data = self.properties.get(name, b"")
        return int.from_bytes(data[:8], "little", signed=True) if len(data) in (4, 8) else None


def recognises(path: Path) -> bool:
    """True for a file that begins as OpenNI's do."""
    return path.is_file() and beginning(path, 4) == START


def read(path: Path, camera: Camera | None) -> Recording:
    """The depth of an `.oni` file; whole frames of one that was cut off. Raises RecordingError."""
    nodes, whole = _nodes(path)
    depths = [node for node in nodes.values() if node.kind == DEPTH and node.parts]
    if not depths:
        raise RecordingError("the recording is empty", path, f"{len(nodes)} streams", "one of depth with frames")
    node = depths[0]
    if node.codec not in ("NONE", "16zP", "16zT"):
        raise RecordingError("depth is packed in a way that is not read", path, node.codec, "NONE, 16zP or 16zT")
    size = node.properties.get("xnMapOutputMode", b"")[:8]
    if len(size) < 8:
        raise RecordingError("the size of the images is not said", path, "no xnMapOutputMode", "width and height")
    width, height = struct.unpack("<II", size)
    check_size(64 * width * height, path, RecordingError, f"a frame of {width} x {height} pixels")
    unit, warnings = (10_000.0 if node.integer("oniPixelFormat") == TENTHS else 1000.0), []
    if camera is None:
        camera = _nominal(node, width, height, path)
        warnings = ["the camera is a nominal one, of the field of view that the file states"]
    elif not camera.width:
        camera = replace(camera, width=width, height=height)
    camera = replace(camera, depth_scale=unit)
    mirrored = bool(node.integer("xnMirror"))
    warnings += ["images are mirrored, says the file: turned back"] if mirrored else []
    warnings += [] if whole else [f"cut off: {len(node.parts)} frames are whole"]
    warnings += [f"{len(depths)} streams of depth: the first is used"] if len(depths) > 1 else []
    warnings += ["colour in this file is not read"] if any(n.parts for n in nodes.values() if n.kind == 3) else []
    stamps, more = even_or_stated(np.array(node.stamps) * 1e-6, FRAMES_PER_SECOND)
    counts = partial(_counts, path, node, (height, width), mirrored)
    source = ImageSource(
        path=path, camera=camera, stamps=stamps, depth=lambda i: counts_to_metres(counts(i), unit), counts=counts
    )
    return source.recording("oni", None, warnings + more)


def _nominal(node: OniStream, width: int, height: int, path: Path) -> Camera:
    """A camera of the stated field of view [rad], as OpenNI itself uses it. Raises RecordingError where none is.

    Its converter (Source/Core/OniStream.cpp, convertDepthToWorldCoordinates) takes the number of a pixel's column:
    X / Z = 2 tan(fov / 2) (column / width - 1 / 2), so the axis goes through pixel width / 2.
    """
    data = node.properties.get("xnFOV", b"")
    across, down = struct.unpack("<2d", data) if len(data) == 16 else (0.0, 0.0)
    if not (0.05 < across < 3 and 0.05 < down < 3):
        do = say_camera("primesense")
        raise RecordingError("the recording has no camera", path, "no field of view", "intrinsics", do)
    fx, fy = width / 2 / np.tan(across / 2), height / 2 / np.tan(down / 2)
    return Camera(width, height, float(fx), float(fy), width / 2, height / 2)


def _counts(path: Path, node: OniStream, shape: tuple[int, int], mirrored: bool, index: int) -> NDArray[np.uint16]:
    data = read_part(path, node.parts[index], "a depth image")
    where = f"{path}, frame {index}"
    if node.codec == "NONE":
        image = counts_of(data, shape, where)
    else:
        unpack = sixteen_z.unpack if node.codec == "16zP" else sixteen_z.unpack_with_table
        try:
            image = unpack(data, shape[0] * shape[1]).reshape(shape)
        except ValueError as problem:
            raise RecordingError("a depth image is damaged", where, problem, "whole data of 16z") from problem
    return np.ascontiguousarray(image[:, ::-1]) if mirrored else image


def _nodes(path: Path) -> tuple[dict[int, OniStream], bool]:
    """The streams by number with the places of their images, and whether the file has its end."""
    nodes: dict[int, OniStream] = {}
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        size = file.seek(0, 2)
        at, count = BEGIN, 0
        while at + RECORD.size <= size:
            file.seek(at)
            magic, kind, number, fields, data, _ = RECORD.unpack(file.read(RECORD.size))
            if magic != MAGIC or not RECORD.size <= fields <= FIELDS or at + fields + data > size:
                return nodes, False
            if kind == END:
                return nodes, True
            values = file.read(fields - RECORD.size)
            if kind in NODES:
                nodes[number] = _node(values)
            elif number in nodes and kind in (INTEGER, GENERAL):
                name, rest = _named(values)
                nodes[number].properties[name] = rest[4:]
            elif number in nodes and kind == DATA and len(values) >= 8 and data:
                count += 1
                check_size(TAKES * count, path, RecordingError, "the list of frames")
                # with a sign: since the first frame, before it where the device's clock was set back
                nodes[number].stamps.append(int.from_bytes(values[:8], "little", signed=True))
                nodes[number].parts.append(ByteRange(at + fields, data))
            at += fields + data
    return nodes, False


def _node(values: bytes) -> OniStream:
    _, rest = _named(values)
    kind = int.from_bytes(rest[:4], "little")
    return OniStream(kind, rest[4:8].decode("ascii", "replace"))


def _named(values: bytes) -> tuple[str, bytes]:
    """A text with its length before it, and what follows."""
    length = int.from_bytes(values[:4], "little")
    return values[4 : 4 + length].rstrip(b"\0").decode("ascii", "replace"), values[4 + length :]
