"""A scene as a file: `scene.json` of a recording, plus `camera` and `trajectory`."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import FusionError, RecordingError, SceneError
from fusion.files.content import Content
from fusion.files.json_file import read_json
from fusion.files.schema import one_of
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.presets import PRESETS, find_camera
from fusion.recording.native.camera_file import CameraFile, camera_of
from fusion.recording.native.scene_file import CourseFields, TableFields
from fusion.recording.native.telemetry_file import read_telemetry
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.simulation.scene.course import SimulatedCourse, standing, turning
from fusion.simulation.scene.parts import read_parts
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scene.source import SceneFile, SceneSource
from fusion.simulation.scene.turntable import Turntable, TurntableErrors


def read_scene(path: Path | str, notes: list[str] | None = None) -> Scene:
    """The scene in a file, or in a recording's folder, whose camera, poses and telemetry are then used.

    Args:
        path: `scene.json`; the paths in it are relative to it.
        notes: keys that are not known, and what the meshes' readers left out, are appended here.

    Raises:
        SceneError: anything in it that cannot be used, in one line.

    >>> scene = fusion.read_scene("my_scan")  # of a recording: the same scene again, for another sensor
    >>> again = fusion.simulate(scene, fusion.read_sensor("kinect-v1"), seed=2)
    """
    path = Path(path)
    path = path / "scene.json" if path.is_dir() else path
    try:
        return _read(path, [] if notes is None else notes)
    except OSError as error:
        raise SceneError("a file of the scene cannot be read", path, error.strerror or error) from error
    except FusionError as error:  # also of a camera, a trajectory, a table, of what is made of the values
        raise SceneError(error.what, _named(error.where, path), error.found, error.expected, error.do) from error


def _named(where: str, path: Path) -> str:
    """The place of an error, with the scene file where that does not name a file."""
    # Path.exists raises for some texts, and any may stand there
    if str(path) in where or os.path.exists(where.split(", ")[0]):  # noqa: PTH110
        return where
    return f"{path}, {where}" if where else str(path)


def _read(path: Path, notes: list[str]) -> Scene:
    content = Content(read_json(path, SceneError, "the scene file"), path, "the scene", SceneError)
    given = content.as_type(SceneFile)
    notes += content.unknown(SceneFile, besides="camera")
    source = SceneSource(content, given, notes)
    camera, course = _camera(source), _course(source)
    parts, paints, board = read_parts(source, course.turntable is not None)
    colored = any(part.mesh.colors is not None and part.reflectance is None for part in parts)
    usual = path.parent.resolve().name if path.name == "scene.json" else path.stem
    return Scene(
        name=str(given.name or usual),
        parts=tuple(parts),
        course=course,
        camera=camera,
        paints=tuple(paints),
        poses=_stated(given, course),
        ambient_lux=given.ambient_lux or 0.0,
        telemetry=_telemetry(source, course),
        color=_or(given.color, colored or board is not None),
        infrared=_or(given.infrared, board is not None),
        board=board,
    )


def _or(value: bool | None, usual: bool) -> bool:
    return usual if value is None else value


def _camera(source: SceneSource) -> Camera | None:
    given = source.given.camera
    if isinstance(given, CameraFile):
        where = f'{source.content.where}, "camera"'
        return camera_of(Content(source.content.value["camera"], where, "the camera", SceneError))
    if given is None:
        beside = source.folder / "camera.json"
        return find_camera(source.path("camera.json", "camera")) if beside.is_file() else None
    if given in PRESETS:
        return find_camera(given)
    path = source.path(given, "camera")
    if not path.is_file():
        raise source.wrong("camera", expected="a camera.json or " + one_of(list(PRESETS), given))
    return find_camera(path)


def _course(source: SceneSource) -> SimulatedCourse:
    given = source.given.trajectory
    if given is None and (source.folder / "groundtruth.txt").is_file():
        given = "groundtruth.txt"
    if given is None:
        raise source.wrong("trajectory")
    if isinstance(given, str):
        path = source.path(given, "trajectory")
        trajectory = read_trajectory(path)
        if trajectory.timestamps[0] == trajectory.timestamps[-1] and len(trajectory) > 1:
            raise RecordingError("all poses have one time stamp", path)
        continuous = _or(source.given.continuous, _moves(trajectory))
        return SimulatedCourse(trajectory.timestamps, trajectory.poses, continuous=continuous)
    return _standing(source, given) if given.turntable is None else _turntable(source, given, given.turntable)


def _moves(trajectory: Trajectory) -> bool:
    """A hand moves from every frame to the next; a camera that is set up stands for a while at each place."""
    steps = np.abs(np.diff(trajectory.poses, axis=0)).max(axis=(1, 2)) if len(trajectory) > 1 else np.zeros(1)
    return bool((steps > 0).mean() > 0.8 and np.median(np.diff(trajectory.timestamps)) < 0.2)


def _standing(source: SceneSource, given: CourseFields) -> SimulatedCourse:
    """A camera that does not move: one pose and a number of frames."""
    T = source.first_pose((given, ("trajectory",)), (source.given, ()))
    frames = int(source.required(given, "frames", "trajectory"))
    return standing([T], frames, given.frame_s or 1 / 30, given.start_s or 0.0)


def _turntable(source: SceneSource, given: CourseFields, table: TableFields) -> SimulatedCourse:
    place = ("trajectory", "turntable")
    # every field of the errors is a number; a slip's frame is a whole one
    told = {} if table.errors is None else {key: getattr(table.errors, key) for key in table.errors.__struct_fields__}
    errors: dict[str, Any] = {key: value for key, value in told.items() if value is not None}
    if "slip_frame" in errors:
        errors["slip_frame"] = int(errors["slip_frame"])
    made = Turntable(
        axis_point=table.axis_point or (0.0, 0.0, 0.0),
        axis_direction=table.axis_direction or (0.0, 0.0, 1.0),
        degrees_per_frame=source.required(table, "degrees_per_frame", *place),
        frames=int(source.required(table, "frames", *place)),
        errors=TurntableErrors(**errors),
    )
    T = source.first_pose((given, ("trajectory",)), (table, place), (source.given, ()))
    continuous = _or(given.continuous, _or(table.continuous, False))
    return turning(made, T, given.frame_s or table.frame_s or 0.5, given.start_s or table.start_s or 0.0, continuous)


def _stated(given: SceneFile, course: SimulatedCourse) -> StatedPoses | None:
    if given.poses == "none":
        return None
    usual, poses = "surveyed" if course.turntable is None else "nominal", given.stated_poses
    return StatedPoses(poses.source or usual, poses.sigma_m or 0.0, poses.sigma_rad or 0.0)


def _telemetry(source: SceneSource, course: SimulatedCourse) -> dict[str, np.ndarray]:
    """Columns at the frames' times, linear between the entries of the table."""
    name = source.given.telemetry
    if name is None:
        name = "telemetry.csv" if (source.folder / "telemetry.csv").is_file() else ""
    if not name:
        return {}
    table = read_telemetry(source.path(name, "telemetry"), source.notes)
    known = {}
    for column, values in table.items():
        good = np.isfinite(values) & np.isfinite(table["timestamp"])
        if column not in ("timestamp", "turntable_deg") and good.any():
            known[column] = np.interp(course.timestamps, table["timestamp"][good], values[good])
    return known
