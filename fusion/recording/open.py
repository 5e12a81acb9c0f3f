"""Opening a recording: what is in the folder or file says which format it is."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import part
from fusion.files.reading import beginning
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import DEVICES, MODES, find_camera
from fusion.recording.cameras.said_camera import are_numbers, said_camera
from fusion.recording.formats import bop, fakenect, not_read, open3d_folder, seven_scenes, tum
from fusion.recording.formats.azure import mkv
from fusion.recording.formats.bags import bag
from fusion.recording.formats.folders import freenect2, nerfstudio, plain, scannet
from fusion.recording.formats.phones import polycam, record3d, stray
from fusion.recording.formats.recorded import klg, oni, sens, xef, xef_depth
from fusion.recording.images.load_frame import check_frame_size
from fusion.recording.native.scene_file import read_scene_fields
from fusion.recording.recording import Frame, Recording

# In the order of asking: the first that recognises it reads it. A format has `recognises(path)`, which looks at content
# and raises nothing, and `read(path, camera)`; one with several depth streams also `HAS_TOPICS` and
# `read(..., topic)`; one whose counts per metre are not stated in the files, `USUAL_SCALE`.
FOLDERS: tuple[ModuleType, ...] = (
    tum,
    bop,
    seven_scenes,
    fakenect,
    scannet,
    open3d_folder,
    bag,
    nerfstudio,
    stray,
    polycam,
    record3d,
    freenect2,
    plain,
)
# any folder of images may be one of the others: to find that out they are opened
TELLING = tuple(form for form in FOLDERS if form not in (freenect2, plain))
FILES: tuple[ModuleType, ...] = (bag, mkv, record3d, polycam, nerfstudio, oni, sens, klg, xef, xef_depth)
READ = "a folder with depth images, or a file of a known format (docs/formats.md)"
NOT_READ = {".exr", ".pfm"}  # kinds of images in which others keep depth


def open_recording(path: Path | str, camera: Camera | Path | str | None = None, topic: str | None = None) -> Recording:
    """Open a recording of any known format; no image is decoded before it is asked for.

    Args:
        path: the folder or the file.
        camera: intrinsics that replace the recording's own: a Camera, a `camera.json`, the name of a preset, or
            "fx,fy,cx,cy" [px].
        topic: which depth stream of a bag that has several.

    Raises:
        RecordingError: it is no recording, its lists cannot be read, it has no camera and none is given, or several
            depth streams of which none is named.

    >>> recording = fusion.open_recording("my_scan")
    >>> [round(float(np.nanmedian(frame.depth)), 1) for frame in recording][:3]  # images are read when they are used
    [0.9, 0.9, 0.9]
    >>> fusion.open_recording("my_scan", camera="kinect-v2").camera
    <Camera: 512 x 424, fx 365.46 fy 365.46 cx 254.88 cy 205.40 px, itof, kinect-v2>
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError("there is no recording", path, "nothing", "a folder with depth images, or a recorded file")
    form = recognised(path)
    if form is None:
        raise not_read.refusal(path) or _part(path) or _not_recognised(path)
    if form is plain and camera is None and (part_of := _part(path)):
        raise part_of
    if getattr(form, "HAS_TOPICS", False):
        read = partial(form.read, path, topic=topic)
    elif topic is not None:
        raise RecordingError("there are no topics in this recording", path, f"--topic {topic}", do="leave it out")
    else:
        read = partial(form.read, path)
    said = camera
    if camera is not None:
        said = said_camera(camera, lambda one: read(camera=one), getattr(form, "USUAL_SCALE", 1000.0))
    recording = read(camera=said)
    check_frame_size(recording.camera, path)
    recording = _without_blind_pixels(recording)
    if str(camera) in DEVICES:
        nominal, source = DEVICES[str(camera)]
        known = any(recording.camera.shape == mode.shape for mode in MODES[str(camera)])
        size = "" if known else f", resized from {nominal.width} x {nominal.height}"
        told = f"the camera is a nominal {camera} ({source}){size}, not calibrated"
        told += f"; depth aligned to colour is {camera}-color" if f"{camera}-color" in DEVICES else ""
        recording = replace(recording, warnings=(*recording.warnings, told))
    scene = part(path, "scene.json", RecordingError)
    return recording if scene is None else replace(recording, scene=read_scene_fields(scene))


def stated_camera(camera: Camera | Path | str | None, path: Path, topic: str | None = None) -> Camera | None:
    """The camera that is said for recordings like this one, where "fx,fy,cx,cy" [px] need its size; None for none.

    Raises:
        RecordingError: as `open_recording`.
    """
    if camera is None:
        return None
    return open_recording(path, camera, topic).camera if are_numbers(camera) else find_camera(camera)


def _without_blind_pixels(recording: Recording) -> Recording:
    """The recording without depth where its camera's lens leaves pixels without a ray; told."""
    blind = recording.camera.blind()
    if blind is None:
        return recording
    told = f"{blind.mean():.1%} of the pixels lie where the formula of the lens turns back: left out"
    return replace(recording, load=partial(_seeing, recording.load, blind), warnings=(*recording.warnings, told))


def _seeing(load: Callable[[int], Frame], blind: NDArray[np.bool_], index: int) -> Frame:
    frame = load(index)
    return replace(frame, depth=np.where(blind, np.float32(np.nan), frame.depth))


def recognised(path: Path) -> ModuleType | None:
    """The format of a folder or file, told by its content; None where it is none."""
    return next((form for form in (FOLDERS if path.is_dir() else FILES) if form.recognises(path)), None)


def _part(path: Path) -> RecordingError | None:
    """What lies in a recording and is none, as shells make of "scan/*"."""
    whole = next((folder for folder in path.parents[:2] if any(form.recognises(folder) for form in TELLING)), None)
    return RecordingError("this is a part of a recording", path, do=f"name the recording: {whole}") if whole else None


def _not_recognised(path: Path) -> RecordingError:
    if path.is_dir():
        return _no_recording_folder(path)
    if not path.is_file():
        return RecordingError("there is no recording", path, "no regular file", "a folder or a recorded file")
    start = beginning(path, 16)
    found = f"a file that begins with {start!r}" if start else "an empty file, or one that cannot be read"
    return RecordingError("the file is no recording", path, found, READ)


def _entries(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _no_recording_folder(folder: Path) -> RecordingError:
    names = sorted(entry.name + "/" * entry.is_dir() for entry in folder.iterdir())
    inside = [name for name in names if name.endswith("/") and any(f.recognises(folder / name) for f in TELLING)]
    found = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
    expected = (
        "depth.txt (native, TUM), frame-000000.depth.png (7-Scenes), scene_camera.json (BOP), "
        "INDEX.txt (fakenect) or depth/ with color/ (Open3D) or pose/ (ScanNet)"
    )
    do = f"open one of the recordings inside: {', '.join(inside[:4])}" if inside else ""
    if others := sorted({entry.suffix for home in (folder, folder / "depth") for entry in _entries(home)} & NOT_READ):
        do = do or f"write the {' and '.join(others)} images as 16-bit PNG (counts) or NPY (metres): they are not read"
    return RecordingError("the folder is no recording", folder, found or "an empty folder", expected, do)
