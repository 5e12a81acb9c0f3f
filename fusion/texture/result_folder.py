"""What a texture is made of, from the folder of a result: its mesh, its recordings, and where their cameras were."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from fusion.errors import FusionError, RecordingError
from fusion.files.content import Content
from fusion.files.json_file import read_json
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording

SAME_STAMP = 2e-6  # [s] trajectory.txt holds microseconds
Focal = Annotated[float, Meta(gt=0, le=1e6, description="[px]")]
Middle = Annotated[float, Meta(ge=-1e6, le=1e6, description="[px]")]


class ResultCamera(Struct):
    """The camera that a result was made with."""

    fx: Focal
    fy: Focal
    cx: Middle
    cy: Middle


class Used(Struct):
    """What is needed of `settings.json`: of a scan, or of a merge of several."""

    recording: str | UnsetType = UNSET
    camera: ResultCamera | UnsetType = UNSET
    passes: list[str] | UnsetType = UNSET
    cameras: list[ResultCamera] | UnsetType = UNSET


def open_result(
    folder: Path, recordings: list[Path] | None = None, camera: Any = None, topic: str | None = None
) -> tuple[Mesh, list[tuple[Recording, Trajectory]]]:
    """The mesh of a result, and each of its recordings with the trajectory (frames) of its camera in the mesh's world.

    Args:
        folder: a result of fusion turntable, reconstruct or merge.
        recordings: where they are now; None: where they were.
        camera, topic: as `open_recording` takes them.

    Raises:
        FusionError: it is no result, or a file of it is missing or wrong.
        RecordingError: a recording is not where it was, or is another one.
    """
    settings = folder / "settings.json"
    if not settings.is_file() or not (folder / "mesh.ply").is_file():
        expected = "a result of fusion turntable, reconstruct or merge: mesh.ply and settings.json"
        raise FusionError("this is no result with a mesh", folder, "something else", expected)
    used = Content(read_json(settings, what="settings.json"), settings, "the result").as_type(Used)
    told = used.passes if used.passes is not UNSET else [used.recording] if used.recording is not UNSET else []
    lenses = used.cameras if used.cameras is not UNSET else [used.camera] * len(told)
    if not told or len(lenses) != len(told):
        raise FusionError("the result does not say what it was made of", settings, do="make it again")
    if recordings and len(recordings) != len(told):
        raise FusionError("the recordings do not fit the result", "--recording", len(recordings), f"{len(told)}")
    several = used.passes is not UNSET
    taken = []
    for k, (name, lens) in enumerate(zip(told, lenses, strict=True)):
        recording = _opened(recordings[k] if recordings else _place(folder, name), camera, topic, lens)
        if lens is not UNSET:
            known = {key: getattr(lens, key) for key in ("fx", "fy", "cx", "cy")}
            recording = replace(recording, camera=replace(recording.camera, **known))
        file = folder / (f"trajectory_{k + 1}.txt" if several else "trajectory.txt")
        course = read_trajectory(file).at(recording.timestamps, SAME_STAMP)
        if not course.valid.any():
            raise RecordingError("the recording is not that of the result", recording.path, "other time stamps")
        taken.append((recording, course))
    return read_mesh(folder / "mesh.ply"), taken


def _opened(path: Path, camera: Any, topic: str | None, lens: ResultCamera | UnsetType) -> Recording:
    """A recording; one that has no camera with that of the result."""
    try:
        return open_recording(path, camera, topic)
    except RecordingError:
        if camera is not None or lens is UNSET:
            raise
        return open_recording(path, f"{lens.fx},{lens.fy},{lens.cx},{lens.cy}", topic)


def _place(folder: Path, told: str) -> Path:
    """Where a recording is: as told, from here or from a folder above the result."""
    for place in (Path(told), *(above / told for above in folder.resolve().parents)):
        if place.exists():
            return place
    do = "run this where the result was made, or name it with --recording"
    raise RecordingError("the recording of a result is not there", folder / "settings.json", told, "its recording", do)
