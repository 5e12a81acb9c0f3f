"""TUM RGB-D folders; the native format is one with a `camera.json` beside the lists."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import inside, part
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.presets import say_camera
from fusion.recording.images.frame_files import ASSOCIATION_SECONDS, FrameFiles, associate, in_time
from fusion.recording.images.load_frame import load_frame, with_color_turned
from fusion.recording.images.read import image_size
from fusion.recording.native.camera_file import read_camera
from fusion.recording.native.device_file import read_settings
from fusion.recording.native.telemetry_file import read_telemetry
from fusion.recording.native.text_files import read_image_list
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.recording import Recording

USUAL_SCALE = 5000.0  # counts per metre of the benchmark's images: its page on file formats
NEXT = 1.5  # usual steps from frame to frame, within which the next one comes


def recognises(folder: Path) -> bool:
    """True for a folder with a list of depth images."""
    return (folder / "depth.txt").is_file()


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a native or plain TUM folder; its images stay on disk. Raises RecordingError."""
    own = part(folder, "camera.json", RecordingError)
    native = own is not None
    if camera is None and own is None:
        do = say_camera("tum-fr1")
        raise RecordingError("the recording has no camera", folder, "no camera.json", "intrinsics", do)
    camera = camera or read_camera(own or "")
    stamps, files = _read_lists(folder)
    files, warnings = with_color_placed(files, camera)
    files, more = _with_ir_placed(files, camera)
    warnings += more
    telemetry = part(folder, "telemetry.csv", RecordingError)
    logged = {} if telemetry is None else read_telemetry(telemetry, warnings)
    settings = read_settings(folder, warnings) if native else {}
    return Recording(
        path=folder,
        format="native" if native else "tum",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=_read_poses(folder),
        telemetry=logged,
        warnings=(*_list_warnings(files), *warnings),
        files=files,
        settings=settings,
    )


def with_color_placed(files: FrameFiles, camera: Camera) -> tuple[FrameFiles, list[str]]:
    """The files with colour images that are not in the depth camera's pixels set apart, or left out with the reason."""
    first = next((name for name in files.color if name is not None), None)
    if first is None:
        return files, []
    seen_by = camera if camera.color is None or _registered(camera, camera.color) else camera.color
    reason, told = "", list[str]()
    if seen_by is not camera and camera.T_color_depth is None:
        reason = "camera.json does not say where the colour camera stands (T_color_depth)"
    else:
        near = replace(camera, color=None) if seen_by is camera else camera
        files, names, told = with_color_turned(files, files.color, near)
        files = replace(files, color=names)
        size = _size(files.folder / first, seen_by)
        if size != (seen_by.width, seen_by.height) and not told:
            whose = "the depth images" if seen_by is camera else "the colour camera"
            reason = f"its images are {size[0]} x {size[1]}, {whose} {seen_by.width} x {seen_by.height}"
    if reason:
        return replace(files, color=()), [f"colour is not registered to depth and left out: {reason}"]
    return files if seen_by is camera else replace(files, color=(), color_apart=files.color), told


def _with_ir_placed(files: FrameFiles, camera: Camera) -> tuple[FrameFiles, list[str]]:
    """The files without infrared images that are not in the depth camera's pixels, and the reason."""
    first = next((name for name in files.ir if name is not None), None)
    size = (camera.width, camera.height) if first is None else _size(files.folder / first, camera)
    if size == (camera.width, camera.height):
        return files, []
    reason = f"its images are {size[0]} x {size[1]}, the depth images {camera.width} x {camera.height}"
    return replace(files, ir=()), [f"infrared is not in the depth camera's pixels and left out: {reason}"]


def _size(path: Path, camera: Camera) -> tuple[int, int]:
    """(width, height) [px] of an image; the camera's where it cannot be read: told when that frame is loaded."""
    try:
        return image_size(path)
    except RecordingError:
        return camera.width, camera.height


def _registered(camera: Camera, color: Camera) -> bool:
    """True where the colour images are in the depth camera's pixels."""
    if color.shape != camera.shape:
        return False
    T = camera.T_color_depth
    # a place that is not stated: images of the same size were always taken for registered
    return T is None or (
        np.allclose(T, np.eye(4), atol=1e-6) and np.allclose(color.parameters, camera.parameters, rtol=1e-3)
    )


def _read_lists(folder: Path) -> tuple[NDArray[np.float64], FrameFiles]:
    unsorted, names = read_image_list(inside(folder, "depth.txt", RecordingError))
    if not names:
        raise RecordingError("the recording is empty", folder / "depth.txt", "no frame", "lines timestamp filename")
    given = np.array(unsorted)
    order = np.argsort(given, kind="stable")
    stamps = given[order]
    color, unmatched_color = _associated(part(folder, "rgb.txt", RecordingError), stamps)
    ir, unmatched_ir = _associated(part(folder, "ir.txt", RecordingError), stamps)
    unmatched = {"rgb.txt": unmatched_color, "ir.txt": unmatched_ir}
    files = FrameFiles(
        folder=folder,
        depth=[names[i] for i in order],
        color=color,
        ir=ir,
        steps_back=int((np.diff(given) < 0).sum()),
        unmatched={name: counts for name, counts in unmatched.items() if counts[1]},
    )
    return stamps, files


def _associated(path: Path | None, stamps: NDArray[np.float64]) -> tuple[list[str | None], tuple[int, int]]:
    """File name per depth stamp, and (images that belong to no frame, images in the list)."""
    if path is None:
        return [], (0, 0)
    other, names = read_image_list(path)
    match = associate(stamps, np.array(other))
    matched = [names[i] if i >= 0 else None for i in match] if (match >= 0).any() else []
    return matched, (_without_frame(np.array(other), stamps), len(names))


def _without_frame(other: NDArray[np.float64], stamps: NDArray[np.float64]) -> int:
    """How many images (m,) belong to none of the depth frames (n,), in the order of time.

    One that follows the last frame in step is no loss: its recording was cut off before the depth, which comes last.
    """
    lost = other[~in_time(other, stamps)]
    step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    return 0 if len(lost) == 1 and 0 < lost[0] - stamps[-1] < NEXT * step else len(lost)


def _read_poses(folder: Path) -> Trajectory | None:
    path = part(folder, "groundtruth.txt", RecordingError)
    return None if path is None else read_trajectory(path)


def _list_warnings(files: FrameFiles) -> list[str]:
    warnings = []
    if files.steps_back:
        warnings.append(f"depth.txt is not in the order of time ({files.steps_back} steps back): sorted")
    for name, (lost, total) in files.unmatched.items():
        if lost:
            warnings.append(f"{lost} of {total} images of {name} have no depth frame within {ASSOCIATION_SECONDS:g} s")
    return warnings
