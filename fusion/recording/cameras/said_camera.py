"""A camera that is said where a recording is opened: a file, a preset, or four numbers."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.cameras.laid import in_proportion
from fusion.recording.cameras.presets import MODES, PRESETS, find_camera
from fusion.recording.images.read import image_size
from fusion.recording.native.camera_file import LEAST_SCALE, MOST_SCALE, are_focal
from fusion.recording.recording import Recording

Read = Callable[[Camera | None], Recording]


def said_camera(camera: Camera | Path | str, read: Read, usual_scale: float = 1000.0) -> Camera:
    """The camera that is meant; of `fx,fy,cx,cy` [px] the rest is the recording's own, or the size of its images.

    Args:
        camera: a Camera, a `camera.json` or a file of others (that may leave the size to the images), the name of a
            preset (in the mode of the images' size, or resized), or the four numbers, a fifth for the counts per metre.
        read: opens the recording with a camera.
        usual_scale: counts per metre of a format that states none.

    Raises:
        RecordingError: it is none of these.
    """
    numbers = _numbers(camera)
    if numbers is None:
        found = find_camera(camera, lambda: _size_of_images(read))
        return _of_a_mode(str(camera), read(found)) if str(camera) in PRESETS else found
    fx, fy, cx, cy, *scales = numbers
    if not are_focal(fx, fy) or max(abs(cx), abs(cy)) > 1e6:
        raise RecordingError("the camera cannot be used", "--camera", camera, "fx,fy,cx,cy in pixels")
    if any(not LEAST_SCALE <= scale <= MOST_SCALE for scale in scales):
        raise RecordingError("the camera cannot be used", "--camera", camera, "fx,fy,cx,cy,counts per metre")
    try:
        own = read(None)
    except RecordingError:  # most states no camera; if it is something else it is met again
        opened = read(Camera(0, 0, fx, fy, cx, cy, depth_scale=scales[0] if scales else usual_scale))
        return opened.camera if opened.camera.width else _of_images(opened)
    found = replace(_of_images(own), fx=fx, fy=fy, cx=cx, cy=cy, distortion=(), std={})
    return replace(found, depth_scale=scales[0]) if scales else found


def _of_a_mode(preset: str, recording: Recording) -> Camera:
    """The preset as its device makes images of that size: one of its modes, or one evenly resized."""
    seen = _of_images(recording)
    size = seen.width, seen.height
    fitting = [mode for mode in MODES[preset] if in_proportion(size, (mode.width, mode.height))]
    mode = min(fitting or MODES[preset][:1], key=lambda mode: abs(mode.width - seen.width))
    return mode if not fitting or mode.shape == seen.shape else mode.resized(*size)


def _size_of_images(read: Read) -> tuple[int, int]:
    """Width and height; any camera opens a recording that states none."""
    opened = _of_images(read(Camera(0, 0, 1.0, 1.0, 0.0, 0.0)))
    return opened.width, opened.height


def _of_images(recording: Recording) -> Camera:
    """The camera with the size of the depth images, where they are files: a usual camera's may be another."""
    files, camera = recording.files, recording.camera
    if files is None:
        return camera
    try:
        width, height = image_size(files.folder / files.depth[0])
    except RecordingError:
        if not camera.width:
            raise
        return camera
    return replace(camera, width=width, height=height)


def are_numbers(camera: Camera | Path | str) -> bool:
    """True for "fx,fy,cx,cy", with the counts per metre behind them or not."""
    return _numbers(camera) is not None


def _numbers(camera: Camera | Path | str) -> list[float] | None:
    """The four or five numbers; None where it is something else."""
    parts = [] if isinstance(camera, Camera) else str(camera).split(",")
    if len(parts) not in (4, 5):
        return None
    try:
        return [float(part) for part in parts]
    except ValueError:
        return None
