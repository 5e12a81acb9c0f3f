"""Dumps of libfreenect's fakenect: `INDEX.txt`, `d-*.pgm` depth, `r-*.ppm` colour of a Kinect v1."""

import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.files.inside import all_inside, inside, part
from fusion.files.json_file import read_json
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.cameras.zero_plane import DEPTH_SCALE, NO_VALUE, USUAL, ZeroPlane
from fusion.recording.images.frame_files import INVALID_COUNT, FrameFiles, associate
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import check_shape, read_bytes
from fusion.recording.native.text_files import data_lines, stamp
from fusion.recording.recording import Recording

DEVICE = "device.json"  # newer versions write down what the unit tells of itself
HEADER = re.compile(rb"P5\s+(\d{1,5})\s+(\d{1,5})\s+(\d{1,5})\s")


class _Plane(msgspec.Struct):
    """zero_plane_info; lengths in centimetres. Within a factor of three nothing else is a Kinect."""

    dcmos_emitter_distance: Annotated[float, Meta(gt=2.5, lt=22.5)]
    dcmos_rcmos_distance: Annotated[float, Meta(gt=0.5, lt=10)]
    reference_distance: Annotated[float, Meta(gt=40, lt=360)]
    reference_pixel_size: Annotated[float, Meta(gt=0.03, lt=0.32)]


class _Registration(msgspec.Struct):
    zero_plane_info: _Plane


class _Device(msgspec.Struct):
    reg_info: _Registration
    const_shift: Annotated[float, Meta(ge=0, le=1000)]


def recognises(folder: Path) -> bool:
    """True for a folder with fakenect's index of dumped images."""
    return (folder / "INDEX.txt").is_file()


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a fakenect dump, by default with a Kinect v1's nominal camera. Raises RecordingError."""
    index = inside(folder, "INDEX.txt", RecordingError)
    depth, color = _listed(index, "d-"), _listed(index, "r-")
    if not depth:
        raise RecordingError("the recording is empty", index, "no depth image", "lines such as d-1300000000.1-2.pgm")
    stamps = np.array([stamp for stamp, _ in depth])
    order = np.argsort(stamps, kind="stable")
    match = associate(stamps[order], np.array([stamp for stamp, _ in color]))
    swapped, raw = _encoding(folder / depth[0][1])
    plane = _told_plane(folder)
    files = FrameFiles(
        folder=folder,
        depth=[depth[i][1] for i in order],
        color=[color[i][1] if i >= 0 else None for i in match] if (match >= 0).any() else [],
        read_depth=partial(read_pgm, swapped=swapped),
        to_metres=partial(raw_to_metres, table=(plane or USUAL).metres()) if raw else None,
        steps_back=int((np.diff(stamps) < 0).sum()),
    )
    usual = "the depth images hold raw 11-bit values, taken to metres as in a usual Kinect v1: there is no device.json"
    warnings = [usual] if raw and plane is None else []
    warnings += [] if camera else ["the camera is a nominal Kinect v1, not calibrated"]
    warnings += ["colour is not registered to depth: colours are shifted"] if files.color else []
    camera = camera or PRESETS["kinect-v1"][0]
    camera = replace(camera, depth_scale=DEPTH_SCALE) if raw else camera  # raw values are no counts of any length
    stamps = stamps[order]
    return Recording(
        path=folder,
        format="fakenect",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        warnings=tuple(warnings),
        files=files,
    )


def raw_to_metres(raw: NDArray[np.uint16], table: NDArray[np.float32]) -> NDArray[np.float32]:
    """(height, width) [m] of 11-bit values by a table (2048,) of them, NaN where nothing was seen."""
    return np.where(raw > 0, table[np.minimum(raw, NO_VALUE)], np.nan).astype(np.float32)


def read_pgm(path: Path, shape: tuple[int, int] | None = None, swapped: bool = True) -> NDArray[np.uint16]:
    """(height, width) counts of a 16-bit PGM; `swapped`: little endian, as fakenect writes. Raises RecordingError."""
    data = read_bytes(path)
    head = HEADER.match(data)
    if not head or int(head[3]) < 256:
        raise RecordingError("the image is not a 16-bit PGM", path, repr(data[:16]), "P5 width height 65535")
    width, height = int(head[1]), int(head[2])
    if shape is not None:
        check_shape((height, width), shape, path)
    body = data[head.end() : head.end() + 2 * width * height]
    if len(body) < 2 * width * height or not body:
        raise RecordingError("an image is damaged", path, f"{len(body)} bytes", f"{2 * width * height} bytes")
    return np.frombuffer(body, "<u2" if swapped else ">u2").astype(np.uint16).reshape(height, width)


def _listed(index: Path, start: str) -> list[tuple[float, str]]:
    """(stamp [s], name) of the images whose name begins so: `d-<host seconds>-<device ticks>.pgm`."""
    found = []
    for line, text in data_lines(index):
        if text.startswith(start):
            found.append((stamp(text[2:].split("-")[0], index, line), text))
    all_inside(index.parent, [name for _, name in found], RecordingError, index)
    return found


def _told_plane(folder: Path) -> ZeroPlane | None:
    """The unit's own reference plane, where the dump holds it (fakenect/record.c). Raises RecordingError."""
    path = part(folder, DEVICE, RecordingError)
    if path is None:
        return None
    do = f"correct it, or take {DEVICE} away: then a usual Kinect v1 is assumed"
    told = Content(read_json(path, RecordingError), path, "the device", RecordingError, do).as_type(_Device)
    plane = told.reg_info.zero_plane_info
    return ZeroPlane(
        plane.dcmos_emitter_distance,
        plane.dcmos_rcmos_distance,
        plane.reference_distance,
        plane.reference_pixel_size,
        round(told.const_shift),
    )


def _encoding(path: Path) -> tuple[bool, bool]:
    """(little endian, raw 11-bit values) as the first image tells.

    In the wrong byte order neighbours differ wildly. Raw values end at 2047, which stands for no reading;
    millimetres go on and mark no reading with 0.
    """
    readings = [read_pgm(path, swapped=swapped) for swapped in (False, True)]
    jumps = [np.abs(np.diff(reading.astype(np.int64), axis=1)).mean() for reading in readings]
    swapped = bool(jumps[1] < jumps[0])
    counts = readings[int(swapped)]
    known = counts[counts != INVALID_COUNT]
    raw = known.size > 0 and known.max() <= NO_VALUE and (known == NO_VALUE).sum() >= (known == 0).sum()
    return swapped, bool(raw)
