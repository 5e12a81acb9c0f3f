"""A scene as a file: `scene.json` of a recording, plus `camera` and `trajectory`."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import FusionError, RecordingError, SceneError
from fusion.files.json_file import read_json
from fusion.geometry.camera import Camera
from fusion.recording.camera_file import camera_from_dict
from fusion.recording.camera_presets import find_camera
from fusion.recording.telemetry_file import read_telemetry
from fusion.recording.trajectory_file import read_trajectory
from fusion.simulation.course import Course, standing, turning
from fusion.simulation.scene import Scene, StatedPoses
from fusion.simulation.scene_parts import read_parts
from fusion.simulation.scene_values import Values
from fusion.simulation.turntable import Turntable, TurntableErrors

POSE_KEYS = ("T_world_camera", "camera_pose", "pose")
MOST_DEG = 3600.0  # per frame


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
    except SceneError:
        raise
    except OSError as error:
        raise SceneError("a file of the scene cannot be read", path, error.strerror or error) from error
    except FusionError as error:  # of a camera, a trajectory, a table
        raise SceneError(error.what, error.where, error.found, error.expected, error.do) from error


def _read(path: Path, notes: list[str]) -> Scene:
    scene, folder = Values(read_json(path, SceneError, "the scene file"), str(path), notes), path.parent
    camera = _camera(scene, folder)
    course = _course(scene, folder, notes)
    parts, paints, board = read_parts(scene, folder, course.turntable is not None, notes)
    colored = any(part.mesh.colors is not None and part.reflectance is None for part in parts)
    content = Scene(
        name=scene.text("name", path.parent.resolve().name if path.name == "scene.json" else path.stem),
        parts=tuple(parts),
        course=course,
        camera=camera,
        paints=tuple(paints),
        poses=_stated(scene, course),
        ambient_lux=scene.number("ambient_lux", 0.0, 0.0, 1e6),
        telemetry=_telemetry(scene, folder, course),
        color=scene.truth("color", colored or board is not None),
        infrared=scene.truth("infrared", board is not None),
        board=board,
    )
    scene.done()
    return content


def _camera(scene: Values, folder: Path) -> Camera | None:
    content = scene.any("camera")
    if isinstance(content, dict):
        return camera_from_dict(content, f'{scene.where}, "camera"')
    if content is None:
        beside = folder / "camera.json"
        return find_camera(beside) if beside.is_file() else None
    if not isinstance(content, str):
        raise scene.wrong("camera", "the name of a camera.json, or its fields")
    content = scene.text("camera")
    return find_camera(folder / content if (folder / content).is_file() else content)


def _course(scene: Values, folder: Path, notes: list[str]) -> Course:
    content = scene.any("trajectory")
    if content is None and (folder / "groundtruth.txt").is_file():
        content = "groundtruth.txt"
    if isinstance(content, str):
        content = scene.text("trajectory", content)
        trajectory = read_trajectory(folder / content)
        if trajectory.timestamps[0] == trajectory.timestamps[-1] and len(trajectory) > 1:
            raise RecordingError("all poses have one time stamp", folder / content)
        return Course(trajectory.timestamps, trajectory.poses, continuous=scene.truth("continuous", _moves(trajectory)))
    if not isinstance(content, dict):
        raise scene.wrong("trajectory", 'a TUM file, {"turntable": {...}} or {"T_world_camera": ..., "frames": ...}')
    values = scene.below("trajectory")
    course = _turntable(scene, values, notes) if "turntable" in values else _standing(scene, values)
    values.done()
    return course


def _moves(trajectory: Any) -> bool:
    """A hand moves from every frame to the next; a camera that is set up stands for a while at each place."""
    steps = np.abs(np.diff(trajectory.poses, axis=0)).max(axis=(1, 2)) if len(trajectory) > 1 else np.zeros(1)
    return bool((steps > 0).mean() > 0.8 and np.median(np.diff(trajectory.timestamps)) < 0.2)


def _standing(scene: Values, values: Values) -> Course:
    """A camera that does not move: one pose and a number of frames."""
    T = _one_pose(scene, values)
    start = values.number("start_s", 0.0)
    return standing([T], values.whole("frames", None, 1), values.number("frame_s", 1 / 30), start)


def _turntable(scene: Values, values: Values, notes: list[str]) -> Course:
    table = values.below("turntable")
    given = table.below("errors")
    # every field of the errors is a number; a slip's frame is a whole one
    errors: dict[str, Any] = {
        entry.name: given.number(entry.name) for entry in fields(TurntableErrors) if entry.name in given
    }
    if "slip_frame" in errors:
        errors["slip_frame"] = given.whole("slip_frame")
    made = Turntable(
        axis_point=table.vector("axis_point", (0.0, 0.0, 0.0)),
        axis_direction=table.vector("axis_direction", (0.0, 0.0, 1.0)),
        degrees_per_frame=table.number("degrees_per_frame", None, -MOST_DEG, MOST_DEG),
        frames=table.whole("frames", None, 1),
        errors=TurntableErrors(**errors),
    )
    T = _one_pose(scene, values, table)
    course = turning(
        made,
        T,
        values.number("frame_s", table.number("frame_s", 0.5)),
        values.number("start_s", table.number("start_s", 0.0)),
        values.truth("continuous", table.truth("continuous", False)),
    )
    for part in (table, given):
        part.done()
    return course


def _one_pose(scene: Values, *places: Values) -> np.ndarray:
    """The camera's pose beside or in the turntable, or in the scene; else the camera's frame is the world's."""
    for place in (*places, scene):
        T = place.pose(*POSE_KEYS)
        if T is not None:
            return T
    return np.eye(4)


def _stated(scene: Values, course: Course) -> StatedPoses | None:
    usual = "surveyed" if course.turntable is None else "nominal"
    if "poses" in scene and scene.any("poses") == "none":
        return None
    values = scene.below("poses")
    stated = StatedPoses(
        values.text("source", usual),
        values.number("sigma_m", 0.0, 0.0, 10.0),
        values.number("sigma_rad", 0.0, 0.0, 1.0),
    )
    values.done()
    return stated


def _telemetry(scene: Values, folder: Path, course: Course) -> dict[str, np.ndarray]:
    """Columns at the frames' times, linear between the entries of the table."""
    name = scene.text("telemetry", "telemetry.csv" if (folder / "telemetry.csv").is_file() else "")
    if not name:
        return {}
    table = read_telemetry(folder / name)
    known = {}
    for column, values in table.items():
        good = np.isfinite(values) & np.isfinite(table["timestamp"])
        if column not in ("timestamp", "turntable_deg") and good.any():
            known[column] = np.interp(course.timestamps, table["timestamp"][good], values[good])
    return known
