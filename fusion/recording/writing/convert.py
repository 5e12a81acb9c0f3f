"""A recording of any format becomes a native folder."""

from pathlib import Path
from typing import Any

from fusion.errors import RecordingError
from fusion.files.inside import inside
from fusion.files.output.publish import output_folder
from fusion.files.reading import read_bytes
from fusion.recording.native.device_file import write_device
from fusion.recording.native.scene_file import scene_mesh
from fusion.recording.recording import Recording
from fusion.recording.writing.losses import Watched
from fusion.recording.writing.write import MEMBERS, fill_recording, tell, write_png


def convert_recording(recording: Recording, path: Path | str, notes: list[str] | None = None) -> None:
    """Write a recording as a native folder, with the mesh that its `scene.json` names.

    Colour images of a camera beside the depth camera are copied as they are.

    Args:
        recording: any recording.
        path: the new folder, not the recording's own.
        notes: what was left out is appended here; without a list it is logged as a warning.

    Raises:
        RecordingError: a frame cannot be loaded, or `path` is the recording itself.

    >>> fusion.convert_recording(fusion.open_recording("my_scan"), "copied")
    """
    path = Path(path)
    if path.exists() and path.resolve() == recording.path.resolve():
        raise RecordingError("a recording cannot be written onto itself", path, do="name another folder")
    with output_folder(path, replaces=MEMBERS) as partial:
        fill_conversion(partial, recording, notes)


def fill_conversion(folder: Path, recording: Recording, notes: list[str] | None = None) -> None:
    """The same into a folder that is being made."""
    scene = copy_scene_mesh(recording, folder)
    frames = Watched(recording)
    fill_recording(folder, recording.camera, frames, recording.poses, recording.telemetry, scene)
    copy_color_apart(recording, folder)
    if recording.settings:
        write_device(folder, recording.settings)
    gone = "mesh" in scene and not (folder / str(scene["mesh"])).exists()
    told = [f"the mesh of the scene is not there: {scene['mesh']}"] if gone else []
    tell(recording.path, (*recording.warnings, *told, *frames.told()), notes)


def copy_scene_mesh(recording: Recording, folder: Path) -> dict[str, Any]:
    """Copy the mesh that a recording's scene names, where it is there; returns the scene's content, naming the copy.

    Raises:
        RecordingError: the mesh cannot be read, or is named like a part of the recording.
    """
    scene, mesh = dict(recording.scene), _mesh_file(recording)
    if mesh is not None:
        if mesh.name in MEMBERS:
            found, expected = f'"mesh": "{mesh.name}"', "a mesh file, such as scene.ply"
            raise RecordingError("the mesh of the scene is a part of the recording", recording.path, found, expected)
        scene["mesh"] = mesh.name  # beside its scene.json, wherever it was before
        _copy(mesh, folder / scene["mesh"], "the mesh of the scene")
    return scene


def copy_color_apart(recording: Recording, folder: Path) -> None:
    """The colour images that no frame holds, as they are in the depth camera's pixels alone; the list comes last."""
    if not recording.color_is_apart:
        return
    (folder / "rgb").mkdir()
    lines = ["# color images\n# timestamp filename\n"]
    for number, stamp in enumerate(recording.timestamps):
        copied = _one_color_apart(recording, number, folder)
        if copied:
            lines.append(f"{stamp:.6f} {copied}\n")
    (folder / "rgb.txt").write_text("".join(lines), encoding="utf-8")


def _one_color_apart(recording: Recording, number: int, folder: Path) -> str:
    """Name of a frame's colour image in the folder, "" where it has none; a file of its own is copied as it is."""
    files = recording.files
    if files is not None:
        name = files.color_apart[number]
        if name is None:
            return ""
        copied = f"rgb/{number:06d}{Path(name).suffix}"
        _copy(inside(files.folder, name, RecordingError), folder / copied, "the image")
        return copied
    color = recording.color_apart(number)
    if color is None:
        return ""
    copied = f"rgb/{number:06d}.png"
    write_png(folder / copied, color)
    return copied


def _copy(source: Path, target: Path, what: str) -> None:
    """Read, then write: what fails tells which of the two it was."""
    target.write_bytes(read_bytes(source, RecordingError, what))


def _mesh_file(recording: Recording) -> Path | None:
    mesh = scene_mesh(recording)
    if mesh is None or not mesh.exists():
        return None
    if not mesh.is_file():
        raise RecordingError("the mesh of the scene is no file", mesh, "a folder or a device", "a mesh file")
    return mesh
