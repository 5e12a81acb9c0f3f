"""A result folder of `fusion turntable` as a pass: its recording is opened again, nothing is sought anew."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct

from fusion.errors import FusionError, RecordingError
from fusion.files.content import Content
from fusion.files.json_file import read_json
from fusion.mesh.comparison.surface_samples import vertex_normals
from fusion.mesh.files import read_mesh
from fusion.passes.one_pass import Made, Pass, pass_of
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.sensor.presets import PRESETS, default_sensor, preset
from fusion.sensor.sensor import Sensor
from fusion.turntable.selfcheck import DEPTH, NAMES, SelfCheck
from fusion.turntable.views import Region

FILES = ("turntable.json", "settings.json", "trajectory.txt", "mesh.ply")
SAME_STAMP = 2e-6  # [s] trajectory.txt holds microseconds
AGAIN = "scan it again with fusion turntable, or give its recording"


Length = Annotated[float, Meta(gt=1e-5, lt=10.0, description="length [m]")]
Corner = Annotated[list[Annotated[float, Meta(ge=-100, le=100)]], Meta(min_length=3, max_length=3, description="[m]")]
Lens = Annotated[float, Meta(ge=-1e6, le=1e6, description="[px]")]


class Box(Struct):
    """Where the object was found, in the first camera's frame."""

    low: Corner
    high: Corner


class UsedLens(Struct):
    """The camera that a scan used."""

    fx: Annotated[float, Meta(gt=0, le=1e6, description="[px]")]
    fy: Annotated[float, Meta(gt=0, le=1e6, description="[px]")]
    cx: Lens
    cy: Lens


class SettingsFile(Struct):
    """What is needed of `settings.json`."""

    recording: str
    sensor: str
    voxel_m: Length
    truncation_m: Length
    region: Box
    camera: UsedLens
    mask: str | None = None
    keep_plate: bool = False
    sensor_assumed: bool | None = None


class TableFile(Struct):
    """What is needed of `turntable.json`."""

    depth_taken_out: dict[str, float] = {}


@dataclass(frozen=True)
class ResultReading:
    """How the recording of a result is to be read where it does not say so itself."""

    sensor: Sensor | None = None  # None takes what the scan used, if that is known by name
    # camera, topic: as `open_recording` takes them
    camera: Any = None
    topic: str | None = None


def is_result(path: Path) -> bool:
    """Whether a folder is a result of `fusion turntable`, or of a command that writes the same."""
    return all((path / name).is_file() for name in FILES[:2])


def pass_of_result(folder: Path, reading: ResultReading | None = None) -> Pass:
    """The pass of a result.

    Raises:
        FusionError: it is a merge itself, or a file of it is missing or wrong.
        RecordingError: its recording is not where it was.
        SensorError: the model that it was made with is not known by name.
    """
    reading = reading or ResultReading()
    missing = [name for name in (*FILES,) if not (folder / name).is_file()]
    if missing:
        raise FusionError("the scan's result is not whole", folder, f"no {missing[0]}", ", ".join(FILES), AGAIN)
    if (folder / "merge.json").exists():
        raise FusionError("a merge is no pass", folder, "merge.json", "a scan", "give all its passes, and the new one")
    chosen, table = (read_json(folder / name, what=name) for name in ("settings.json", "turntable.json"))
    used = Content(chosen, folder / "settings.json", "the scan", do=AGAIN).as_type(SettingsFile)
    taken = Content(table, folder / "turntable.json", "the scan", do=AGAIN).as_type(TableFile).depth_taken_out
    if used.keep_plate:
        raise FusionError("the plate is in the scan", folder, "--keep-plate", "the object alone", AGAIN)
    recording = open_recording(_recording(folder, used.recording), reading.camera, reading.topic)
    poses = read_trajectory(folder / "trajectory.txt").at(recording.timestamps, SAME_STAMP)
    if poses.valid.sum() < 3:
        raise RecordingError("the recording is not that of the scan", recording.path, "other time stamps", do=AGAIN)
    mesh = read_mesh(folder / "mesh.ply")
    if not len(mesh.faces):
        raise FusionError("the mesh of the scan has no triangles", folder / "mesh.ply", do=AGAIN)
    if mesh.normals is None:
        mesh = type(mesh)(mesh.vertices, mesh.faces, vertex_normals(mesh).astype(np.float32), mesh.colors)
    sensor = reading.sensor or _sensor(used, recording, folder)
    made = Made(
        trajectory=poses,
        mesh=mesh,
        focal=(used.camera.fx, used.camera.fy),
        centre=(used.camera.cx, used.camera.cy),
        region=Region(np.array(used.region.low, float), np.array(used.region.high, float)),
        mask=None if used.mask is None else Path(used.mask),
        voxel=used.voxel_m,
        truncation=used.truncation_m,
        table=table,
        taken_out=taken_out_of(taken, recording),
    )
    return pass_of(recording, sensor, made)


def _recording(folder: Path, told: str) -> Path:
    """Where the recording is: as told, from here or from a folder above the result."""
    for place in (Path(told), *(above / told for above in folder.resolve().parents)):
        if place.exists():
            return place
    do = "run this where the scan was run, or give the recording itself"
    raise RecordingError("the recording of a scan is not there", folder / "settings.json", told, "its recording", do)


def _sensor(used: SettingsFile, recording: Recording, folder: Path) -> Sensor:
    usual, name = default_sensor(recording.camera), used.sensor
    if name == usual.name if used.sensor_assumed is None else used.sensor_assumed:
        return usual
    if name in PRESETS:
        return preset(name)
    do = "pass the file with --sensor"
    raise FusionError("the scan was made with a sensor model of its own", folder, name, "a preset's name", do)


def taken_out_of(taken: dict[str, float], recording: Recording) -> SelfCheck:
    values = np.array([taken.get(name, 0.0) if name in DEPTH else 0.0 for name in NAMES])
    near = taken.get("near", 0.0)
    far = max(taken.get("far", near + 1.0), near + 1e-3)
    return SelfCheck(values, near, far, recording.camera.principle.triangulates)
