"""Opening a recording: what is in the folder says which format it is."""

from dataclasses import replace
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.inside import part
from fusion.geometry.camera import Camera
from fusion.recording.camera_presets import find_camera
from fusion.recording.formats import bop, fakenect, open3d_folder, seven_scenes, tum
from fusion.recording.load_frame import check_frame_size
from fusion.recording.recording import Recording
from fusion.recording.scene_file import read_scene_fields

# in the order of asking: the first that recognises the folder reads it
FORMATS = (tum, bop, seven_scenes, fakenect, open3d_folder)


def open_recording(path: Path | str, camera: Camera | Path | str | None = None) -> Recording:
    """Open a recording of any known format; no image is decoded before it is asked for.

    Args:
        path: the folder.
        camera: intrinsics that replace the recording's own: a Camera, a `camera.json` or the name of a preset.

    Raises:
        RecordingError: the folder is no recording, its lists cannot be read, or it has no camera and none is given.

    >>> recording = fusion.open_recording("my_scan")
    >>> [round(float(np.nanmedian(frame.depth)), 1) for frame in recording][:3]  # images are read when they are used
    [0.9, 0.9, 0.9]
    >>> fusion.open_recording("my_scan", camera="kinect-v2").camera
    <Camera: 512 x 424, fx 365.46 fy 365.46 cx 254.88 cy 205.40 px, itof, kinect-v2>
    """
    folder = Path(path)
    if not folder.is_dir():
        found = "a file" if folder.exists() else "nothing"
        raise RecordingError("there is no recording", folder, found, "a folder with depth images")
    chosen = None if camera is None else find_camera(camera)
    for form in FORMATS:
        if form.recognises(folder):
            recording = form.read(folder, chosen)
            check_frame_size(recording.camera, folder)
            scene = part(folder, "scene.json", RecordingError)
            return recording if scene is None else replace(recording, scene=read_scene_fields(scene))
    raise _not_recognised(folder)


def _not_recognised(folder: Path) -> RecordingError:
    names = sorted(entry.name + "/" * entry.is_dir() for entry in folder.iterdir())
    inside = [name for name in names if name.endswith("/") and any(f.recognises(folder / name) for f in FORMATS)]
    found = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
    expected = (
        "depth.txt (native, TUM), frame-000000.depth.png (7-Scenes), scene_camera.json (BOP), "
        "INDEX.txt (fakenect) or depth/ with color/ (Open3D)"
    )
    do = f"open one of the recordings inside: {', '.join(inside[:4])}" if inside else ""
    return RecordingError("the folder is no recording", folder, found or "an empty folder", expected, do)
