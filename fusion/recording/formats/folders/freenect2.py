"""Depth that programs on libfreenect2 have dumped: bare 512 x 424 float32 millimetres, a file to a frame.

A `libfreenect2::Frame` has no header, so its bytes are all there is; millimetres and the size are the library's
(`libfreenect2.hpp`, `Frame::Depth`). Its images are mirrored, as RTAB-Map turns them (`CameraFreenect2.cpp`).
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.files.reading import open_regular, read_bytes
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.formats.folders.plain import natural
from fusion.recording.formats.recorded.parts import FRAMES_PER_SECOND
from fusion.recording.recording import Recording
from fusion.recording.streamed import REAL_SCALE, ImageSource

WIDTH, HEIGHT = 512, 424
BYTES = 4 * WIDTH * HEIGHT
ENDINGS = (".bin", ".raw", ".dat", ".depth", ".float", ".f32")
NEAREST_MM = 100.0  # the camera sees from 500 mm; infrared, of the same size, has smaller numbers in the dark
FARTHEST_MM = 20_000.0  # the phases of three frequencies repeat at 18.7 m: nothing farther is said
MIRROR = "libfreenect2's images are mirrored: turned back"


def recognises(folder: Path) -> bool:
    """True for a folder with such dumps, in it or in its `depth/`."""
    return bool(_names(folder))


def turned_back(camera: Camera | None, warnings: list[str]) -> Camera:
    """The camera of images that were mirrored: the one that was said, else a nominal Kinect v2, which is told."""
    if camera is None:
        factory = PRESETS["kinect-v2"][0]  # of the mirrored image
        camera = replace(factory, cx=WIDTH - 1 - factory.cx)
        warnings.append("the camera is a nominal Kinect v2, not calibrated")
    return camera if camera.width else replace(camera, width=WIDTH, height=HEIGHT)


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording of dumped depth images, by default with a nominal Kinect v2. Raises RecordingError."""
    names = all_inside(folder, _names(folder), RecordingError)
    warnings = [MIRROR, f"the images have no time stamps: taken for {FRAMES_PER_SECOND:g} a second"]
    camera = turned_back(camera, warnings)
    source = ImageSource(
        path=folder,
        camera=replace(camera, depth_scale=REAL_SCALE),
        stamps=np.arange(len(names)) / FRAMES_PER_SECOND,
        depth=partial(_depth, folder, names),
    )
    return source.recording("libfreenect2", None, warnings)


def _depth(folder: Path, names: list[str], index: int) -> NDArray[np.float32]:
    """(h, w) [m] of a frame, NaN where missing, not mirrored. Raises RecordingError."""
    path = folder / names[index]
    data = read_bytes(path, RecordingError, "a depth image")
    if len(data) != BYTES:
        raise RecordingError("a depth image is of another size", path, f"{len(data)} bytes", f"{BYTES} bytes")
    values = np.frombuffer(data, "<f4").reshape(HEIGHT, WIDTH)[:, ::-1]
    return np.where(_is_length(values), values / np.float32(1000), np.nan).astype(np.float32)


def _is_length(millimetres: NDArray[np.float32]) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        return (millimetres > NEAREST_MM) & (millimetres < FARTHEST_MM)


def _names(folder: Path) -> list[str]:
    """The files of this size, as a person counts, where the first of them is such an image."""
    for place in ("", "depth"):
        here = folder / place
        if not here.is_dir():
            continue
        found = (entry for entry in here.iterdir() if entry.suffix.lower() in ENDINGS and entry.is_file())
        names = sorted((entry.name for entry in found if entry.stat().st_size == BYTES), key=natural)
        if names and _is_depth(here / names[0]):
            return [f"{place}/{name}" if place else name for name in names]
    return []


def _is_depth(path: Path) -> bool:
    """Only nothing (0, infinite, NaN) and lengths: neither infrared nor other bytes are."""
    try:
        with open_regular(path, RecordingError, takes=0) as file:
            values = np.frombuffer(file.read(BYTES), "<f4")
    except (RecordingError, OSError):
        return False
    length = _is_length(values)
    with np.errstate(invalid="ignore"):
        nothing = (values == 0) | ~np.isfinite(values)
    return bool(values.size == WIDTH * HEIGHT and length.any() and (length | nothing).all())
