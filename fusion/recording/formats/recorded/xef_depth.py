"""Depth that XEFExtract takes out of Kinect Studio's `.xef`: `NAME_Depth.dat`, frames of 512 x 424 whole millimetres.

Layout of its writer (github.com/Isaac-W/KinectXEFTools, XEFExtract/XEFWriters/XEFDepthWriter.cs): frames, width, height
and bytes of a frame; then for each its number and its depth. Images are mirrored, as Microsoft's SDK gives them.
"""

import struct
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.reading import open_regular
from fusion.geometry.camera import Camera
from fusion.recording.formats.folders.freenect2 import turned_back
from fusion.recording.formats.recorded.parts import ByteRange, counts_of, read_part
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

HEAD = struct.Struct("<qIII")
WIDTH, HEIGHT = 512, 424
BYTES = 2 * WIDTH * HEIGHT
NUMBER = 8  # bytes before each frame
FRAMES_PER_SECOND = 30.0  # of the device; it halves in the dark, which the file does not say
DEPTH_SCALE = 1000.0  # millimetres


def recognises(path: Path) -> bool:
    """True for a file with this head and a whole frame."""
    return _frames(path)[0] > 0


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in such a file; whole frames of one that was cut off. Raises RecordingError."""
    frames, claimed = _frames(path)
    if not frames:
        raise RecordingError("the recording is empty", path, "no whole frame", "one or more")
    warnings = ["images are mirrored, as Microsoft's SDK gives them: turned back"]
    warnings += [f"the file holds no time stamps: frames are taken for {FRAMES_PER_SECOND:g} a second"]
    # 0: its writer was stopped before it wrote the number
    warnings += [f"cut off: {frames} of {claimed} frames are whole"] if frames < claimed else []
    camera = turned_back(camera, warnings)
    counts = partial(_counts, path)
    source = ImageSource(
        path=path,
        camera=replace(camera, depth_scale=DEPTH_SCALE),
        stamps=np.arange(frames) / FRAMES_PER_SECOND,
        depth=lambda index: counts_to_metres(counts(index), DEPTH_SCALE),
        counts=counts,
    )
    return source.recording("xef-depth", None, warnings)


def _frames(path: Path) -> tuple[int, int]:
    """Whole frames in a file, and how many it claims; none where it is not of this format."""
    try:
        with open_regular(path, RecordingError, takes=0) as file:
            size = file.seek(0, 2)
            file.seek(0)
            claimed, *sizes = HEAD.unpack(file.read(HEAD.size))
    except (RecordingError, struct.error, OSError, ValueError):
        return 0, 0
    if sizes != [WIDTH, HEIGHT, BYTES] or claimed < 0:
        return 0, 0
    whole = (size - HEAD.size) // (NUMBER + BYTES)
    return min(whole, claimed or whole), claimed


def _counts(path: Path, index: int) -> NDArray[np.uint16]:
    """(h, w) millimetres of a frame, 0 where missing, not mirrored. Raises RecordingError."""
    begin = HEAD.size + index * (NUMBER + BYTES) + NUMBER
    data = read_part(path, ByteRange(begin, BYTES), "a depth image")
    return np.ascontiguousarray(counts_of(data, (HEIGHT, WIDTH), f"{path}, frame {index}")[:, ::-1])
