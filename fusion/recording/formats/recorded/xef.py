"""Kinect Studio's `.xef`: depth of a Kinect v2 in millimetres, with its infrared, plain or packed.

Images are mirrored, as Microsoft's SDK gives them. No reader of the format knows where the unit's own camera stands in
the file, so it is a nominal Kinect v2 unless one is given; nor where colour lies beside depth, so colour is left out.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.reading import beginning
from fusion.geometry.camera import Camera
from fusion.recording.formats.folders.freenect2 import turned_back
from fusion.recording.formats.recorded.parts import counts_of, even_or_stated, read_part, unzipped
from fusion.recording.formats.recorded.xef_events import BEGINNING, Events, XefStream, events_of
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

DEPTH = UUID("0a3914d6-3b16-11e1-aac3-001e4fd58c0f")
INFRARED = UUID("0a3914d7-3b16-11e1-aac3-001e4fd58c0f")
COLOR = (UUID("2ba0d67d-be11-4534-9444-3fb21ae0f08b"), UUID("0a3914dc-3b16-11e1-aac3-001e4fd58c0f"))
WIDTH, HEIGHT = 512, 424
BYTES = 2 * WIDTH * HEIGHT
TICK_S = 1e-7
FRAMES_PER_SECOND = 30.0
DEPTH_SCALE = 1000.0  # millimetres


def recognises(path: Path) -> bool:
    """True for a file that begins as Kinect Studio's do."""
    return beginning(path).startswith(BEGINNING)


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in a `.xef` file; whole frames of one that was cut off. Raises RecordingError."""
    events = events_of(path, {DEPTH: BYTES, INFRARED: BYTES})
    depth = events.of(DEPTH)
    if depth is None or not depth.parts:
        found = "no depth stream" if depth is None else "no whole depth image"
        do = "record it again with depth chosen in Kinect Studio" if depth is None else ""
        raise RecordingError("the recording has no depth", path, found, "depth images of a Kinect v2", do)
    warnings = ["images are mirrored, as Microsoft's SDK gives them: turned back"]
    stamps, told = even_or_stated(TICK_S * np.array(depth.ticks, np.float64), FRAMES_PER_SECOND)
    warnings += told + _left_out(events)
    camera = turned_back(camera, warnings)
    counts, infrared = partial(_pixels, path, depth, "a depth image"), events.of(INFRARED)
    places = _infrared(infrared, depth)
    source = ImageSource(
        path=path,
        camera=replace(camera, depth_scale=DEPTH_SCALE),
        stamps=stamps,
        depth=lambda index: counts_to_metres(counts(index), DEPTH_SCALE),
        counts=counts,
        ir=None if infrared is None else partial(_beside, path, infrared, places),
        has_ir=places >= 0,
    )
    return source.recording("xef", None, warnings)


def _left_out(events: Events) -> list[str]:
    """What is told of a file: where it breaks off, colour that cannot be placed."""
    told = [] if events.broken is None else [f"cut off or damaged at byte {events.broken}: frames before it are used"]
    if any(events.of(kind) is not None for kind in COLOR):
        told.append("colour is left out: the file does not say where its camera stands beside the depth camera")
    return told


def _infrared(infrared: XefStream | None, depth: XefStream) -> NDArray[np.int64]:
    """For each depth image the infrared image of the same number and moment, -1 where there is none."""
    at: dict[tuple[int, int], int] = {}
    if infrared is not None:
        at = {key: place for place, key in enumerate(zip(infrared.ticks, infrared.numbers, strict=True))}
    return np.array([at.get(key, -1) for key in zip(depth.ticks, depth.numbers, strict=True)])


def _beside(path: Path, infrared: XefStream, places: NDArray[np.int64], index: int) -> NDArray[np.uint16] | None:
    place = int(places[index])
    return None if place < 0 else _pixels(path, infrared, "an infrared image", place)


def _pixels(path: Path, stream: XefStream, what: str, index: int) -> NDArray[np.uint16]:
    """(h, w) numbers of an image, not mirrored. Raises RecordingError."""
    data, where = read_part(path, stream.parts[index], what), f"{path}, frame {index}"
    data = unzipped(data, BYTES, where, what) if stream.packed else data
    return np.ascontiguousarray(counts_of(data, (HEIGHT, WIDTH), where)[:, ::-1])
