"""Loading one frame from its files: counts to metres, missing to NaN, sizes checked."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError, RecordingError
from fusion.files.limits import check_size
from fusion.geometry.camera import Camera
from fusion.recording.cameras.turned import found_turn
from fusion.recording.images.frame_files import INVALID_COUNT, FrameFiles
from fusion.recording.images.read import check_shape, image_size, read_ir
from fusion.recording.recording import Frame

PIXEL_TAKES = 64  # bytes of a pixel in work: counts, depth, a point, a normal, a ray, a weight


def check_frame_size(camera: Camera, where: object, error: type[FusionError] = RecordingError) -> None:
    """Refuse a camera whose frames would take more memory than is allowed. Raises `error`."""
    size = f"a frame of {camera.width} x {camera.height} pixels"
    check_size(PIXEL_TAKES * camera.width * camera.height, where, error, size)


def load_frame(files: FrameFiles, camera: Camera, timestamps: NDArray[np.float64], index: int) -> Frame:
    """The frame with this index.

    A colour or IR image whose size is not that of the depth image is not in the depth camera's pixels: it is left out,
    which `Frame.unfit` names.

    Raises:
        RecordingError: an image is missing, damaged, or its size is not the camera's.
    """
    color, ir = _name(files.color, index), _name(files.ir, index)
    depth = load_depth(files, camera, index)
    colors = None if color is None else files.read_color(color, camera.shape)
    amplitude = None if ir is None else read_ir(files.folder / ir)
    unfit = []
    if colors is not None and colors.shape[:2] != camera.shape:
        colors, unfit = None, ["color"]
    if amplitude is not None and amplitude.shape != camera.shape:
        amplitude, unfit = None, [*unfit, "ir"]
    return Frame(index, float(timestamps[index]), depth, colors, amplitude, tuple(unfit))


def load_depth(files: FrameFiles, camera: Camera, index: int) -> NDArray[np.float32]:
    """(height, width) [m] depth of one frame, NaN where missing. Raises RecordingError."""
    path = files.folder / files.depth[index]
    counts = files.read_depth(path, camera.shape)
    check_shape(counts.shape, camera.shape, path)
    if files.to_metres is not None:
        return files.to_metres(counts)
    return counts_to_metres(counts, camera.depth_scale)


def with_color_turned(
    files: FrameFiles, names: Sequence[str | None], camera: Camera
) -> tuple[FrameFiles, Sequence[str | None], list[str]]:
    """Files whose colour images `names` are turned to fit their camera; the names, none where that is not clear; words.

    `camera`: of depth; its `color` where the images have pixels of their own.
    """
    shape = (camera.color or camera).shape
    turn, told = found_turn(
        np.array([name is not None for name in names]),
        lambda index: None if (name := names[index]) is None else files.read_color(name, shape),
        lambda index: load_depth(files, camera, index),
        camera,
        stored_shape(files.folder, names),
    )
    return (files, (), told) if turn is None else (replace(files, turn=turn), names, told)


def stored_shape(folder: Path, names: Sequence[str | None]) -> tuple[int, int] | None:
    """(height, width) of the first image that has a name; None where there is none, or it cannot be read."""
    first = next((name for name in names if name is not None), None)
    try:
        return None if first is None else image_size(folder / first)[::-1]
    except RecordingError:  # told by the frame that is asked for
        return None


def counts_to_metres(counts: NDArray[np.uint16], depth_scale: float) -> NDArray[np.float32]:
    """(height, width) [m] of counts; 0 and 65535 become NaN."""
    depth = counts.astype(np.float32)
    depth[(counts == 0) | (counts == INVALID_COUNT)] = np.nan
    return depth / np.float32(depth_scale)


def _name(names: object, index: int) -> str | None:
    return names[index] if names else None  # type: ignore[index]
