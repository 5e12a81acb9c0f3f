"""Azure Kinect's and Orbbec Femto's `.mkv`: Matroska with depth and infrared of 16 bits, colour, a calibration.

Seen in files of the maker's own library (libk4arecord 1.4). Depth is planar z in millimetres; stamps are the device's
clock: those of the file and K4A_START_OFFSET_NS.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.files.json_file import json_in
from fusion.files.limits import check_size
from fusion.files.reading import beginning
from fusion.geometry.camera import Camera, Principle
from fusion.recording.formats.azure.calibration import DO, Calibration, cameras_of
from fusion.recording.formats.azure.matroska import START, Matroska, Track, read_matroska
from fusion.recording.formats.azure.pictures import (
    PACKED,
    PLAIN,
    TrackPictures,
    blind_pixels,
    color_image,
    counts,
    grey_image,
)
from fusion.recording.formats.recorded.parts import read_part
from fusion.recording.images.frame_files import ASSOCIATION_SECONDS, associate, in_time
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

DEPTH_SCALE = 1000.0  # millimetres
# of the file's tags: how the device was set
TOLD = {
    "K4A_DEPTH_MODE": "depth mode",
    "K4A_COLOR_MODE": "color mode",
    "K4A_DEPTH_FIRMWARE_VERSION": "depth firmware",
    "K4A_COLOR_FIRMWARE_VERSION": "color firmware",
    "K4A_DEPTH_DELAY_NS": "depth delay [ns]",
    "K4A_WIRED_SYNC_MODE": "wired sync mode",
    "K4A_DEVICE_SERIAL_NUMBER": "serial number",
}


def recognises(path: Path) -> bool:
    """True for a Matroska file with a track of such depth."""
    if not path.is_file() or beginning(path, 4) != START:
        return False
    try:
        return _track(read_matroska(path, heads_only=True), "DEPTH") is not None
    except (RecordingError, OSError):
        return False


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in such a file; whole frames of one that was cut off. Raises RecordingError."""
    held = read_matroska(path)
    depth, ir, color = (_track(held, name) for name in ("DEPTH", "IR", "COLOR"))
    if depth is None or not depth.parts:
        raise RecordingError("the recording is empty", path, "no image of depth", "one or more")
    check_size(64 * depth.width * depth.height, path, RecordingError, "a frame of depth")
    warnings = [] if held.whole else [f"cut off: {len(depth.parts)} frames are whole"]
    known = _calibration(path, held, depth, color, needed=camera is None)
    stated = _stated(camera, known, held, depth)
    stamps = _stamps(held, depth)
    colors, pixels = _colors(path, held, color, stated.color, stamps, warnings)
    grey = None if ir is None or ir.size != depth.size else _beside(path, held, ir, stamps)
    blind = None if known is None else blind_pixels(known)
    stored = partial(counts, path, depth, blind)
    source = ImageSource(
        path=path,
        camera=stated,
        stamps=stamps,
        depth=lambda index: counts_to_metres(stored(index), DEPTH_SCALE),
        color=None if colors is None else partial(color_image, colors, pixels),
        has_color=np.zeros(0, bool) if colors is None else colors.at >= 0,
        counts=stored,
        ir=None if grey is None else partial(grey_image, grey),
        has_ir=np.zeros(0, bool) if grey is None else grey.at >= 0,
    )
    told = {name: held.tags[tag] for tag, name in TOLD.items() if tag in held.tags}
    return source.recording("azure-mkv", None, warnings, told)


def _track(held: Matroska, name: str) -> Track | None:
    """The track of this name; depth and infrared in numbers of 16 bits."""
    wanted = {"COLOR": {PACKED, *PLAIN}}.get(name, {"b16g"})
    found = (track for track in held.tracks.values() if track.name == name and track.codec in wanted)
    return next((track for track in found if track.width and track.height), None)


def _calibration(path: Path, held: Matroska, depth: Track, color: Track | None, needed: bool) -> Calibration | None:
    """The attached calibration. Raises RecordingError where it is `needed` and cannot be used."""
    name = held.tags.get("K4A_CALIBRATION_FILE", "calibration.json")
    where, what = f"{path}, {name}", "the calibration"
    try:
        if name not in held.files:
            raise RecordingError("the recording has no camera", path, f"no attachment {name}", what, DO)
        text = read_part(path, held.files[name], what).rstrip(b"\0").decode("utf-8", "replace")
        content = Content(json_in(text, where, RecordingError, what), where, what, RecordingError, DO)
        return cameras_of(content, depth.size, None if color is None else color.size)
    except RecordingError:
        if needed:
            raise
    return None


def _stated(camera: Camera | None, known: Calibration | None, held: Matroska, depth: Track) -> Camera:
    """The camera that was given, else the file's; the file's colour camera beside it where it has none."""
    serial = held.tags.get("K4A_DEVICE_SERIAL_NUMBER", "")
    if camera is None:
        assert known is not None
        camera = replace(known.depth, principle=Principle.TIME_OF_FLIGHT, sensor="azure-kinect", serial=serial)
    elif not camera.width:
        camera = replace(camera, width=depth.width, height=depth.height)
    if camera.color is None and known is not None and known.color is not None:
        camera = replace(camera, color=known.color, T_color_depth=known.T_color_depth)
    return replace(camera, depth_scale=DEPTH_SCALE)


def _stamps(held: Matroska, track: Track) -> NDArray[np.float64]:
    """[s] of the device's clock."""
    words = held.tags.get("K4A_START_OFFSET_NS", "0")
    start = int(words) if words.isascii() and words.isdigit() and len(words) < 19 else 0
    return (np.array(track.ticks, float) * held.scale + start) * 1e-9


def _beside(path: Path, held: Matroska, track: Track, stamps: NDArray[np.float64]) -> TrackPictures:
    return TrackPictures(path, track, associate(stamps, _stamps(held, track)))


def _colors(
    path: Path,
    held: Matroska,
    track: Track | None,
    camera: Camera | None,
    stamps: NDArray[np.float64],
    told: list[str],
) -> tuple[TrackPictures | None, tuple[int, int]]:
    """The colour images and their size (width, height), None where they cannot be placed; what is told is appended."""
    if track is None or not track.parts:
        return None, (0, 0)
    if camera is None:
        told.append("colour is not registered to depth and left out: its camera is not stated")
        return None, (0, 0)
    check_size(16 * track.width * track.height, path, RecordingError, "a colour image")
    lost = int((~in_time(_stamps(held, track), stamps)).sum())
    if lost:
        told.append(f"{lost} of {len(track.parts)} colour images have no depth frame within {ASSOCIATION_SECONDS:g} s")
    colors = _beside(path, held, track, stamps)
    without = int((colors.at < 0).sum())
    if without:
        told.append(f"{without} of {len(stamps)} frames have no colour image")
    return colors, track.size
