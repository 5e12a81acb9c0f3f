"""A recording of any format becomes a native folder."""

import shutil
from pathlib import Path

from fusion.errors import RecordingError
from fusion.output import atomic_file
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.recording.write import write_recording


def convert_recording(recording: Recording, path: Path | str) -> None:
    """Write a recording as a native folder, with the mesh that its `scene.json` names.

    Colour images of a camera beside the depth camera are copied as they are.

    Args:
        recording: any recording.
        path: the new folder, not the recording's own.

    Raises:
        RecordingError: a frame cannot be loaded, or `path` is the recording itself.

    >>> fusion.convert_recording(fusion.open_recording("my_scan"), "copied")
    """
    path = Path(path)
    if path.exists() and path.resolve() == recording.path.resolve():
        raise RecordingError("a recording cannot be written onto itself", path, do="name another folder")
    scene, mesh = dict(recording.scene), _mesh_file(recording)
    if mesh is not None:
        # beside its scene.json, wherever it was before
        scene["mesh"] = mesh.name
    write_recording(path, recording.camera, each(recording, "converting"), recording.poses, recording.telemetry, scene)
    _copy_color_apart(recording, path)
    if mesh is not None:
        with atomic_file(path / mesh.name) as partial:
            shutil.copyfile(mesh, partial)


def _copy_color_apart(recording: Recording, path: Path) -> None:
    """The colour images that no frame holds, as they are in the depth camera's pixels alone; the list comes last."""
    files = recording.files
    if files is None or not any(files.color_apart):
        return
    (path / "rgb").mkdir()
    lines = ["# color images\n# timestamp filename\n"]
    for number, (stamp, name) in enumerate(zip(recording.timestamps, files.color_apart, strict=True)):
        if name is None:
            continue
        copied = f"rgb/{number:06d}{Path(name).suffix}"
        try:
            shutil.copyfile(files.folder / name, path / copied)
        except OSError as error:
            raise RecordingError("the image cannot be copied", files.folder / name, error.strerror) from error
        lines.append(f"{stamp:.6f} {copied}\n")
    with atomic_file(path / "rgb.txt") as partial:
        partial.write_text("".join(lines), encoding="utf-8")


def _mesh_file(recording: Recording) -> Path | None:
    name = recording.scene.get("mesh")
    if not isinstance(name, str) or not name or "\0" in name:
        return None
    mesh = recording.path / name
    return mesh if mesh.is_file() else None
