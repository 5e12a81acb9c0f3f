"""A simulation as a recording's folder, with the truth beside it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fusion import __version__
from fusion.files.json_values import json_text
from fusion.files.output.publish import output_folder
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from fusion.progress import each
from fusion.recording.native.camera_file import write_camera
from fusion.recording.native.trajectory_file import write_trajectory
from fusion.recording.writing.write import MEMBERS, fill_recording
from fusion.sensor.files.sensor_file import write_sensor
from fusion.simulation.scene.check import check_sight
from fusion.simulation.simulate import Simulation

OURS = ("scene.ply", "board.json", "truth")


def write_simulation(folder: Path | str, simulation: Simulation) -> None:
    """Write a native recording with `scene.json`, `scene.ply`, `board.json` and `truth/`; whole or not at all.

    `truth/` holds what a real recording cannot know: `trajectory.txt` (true poses), `mesh.ply` (what a scan should
    give), `camera.json` (that took the pictures), `sensor.json`, `truth.json` (seed, true table angles).

    Raises:
        SceneError: the camera sees nothing of the scene, or nothing within the range of the depth images.
        FusionError: the folder cannot be made.

    >>> wall = fusion.built_in("wall", {"distance_m": (0.8, 1.2), "frames": 1})
    >>> fusion.write_simulation("walls", fusion.simulate(wall, fusion.Sensor()))
    >>> fusion.open_recording("walls")
    <Recording walls: native, 2 frames of 640 x 480 in 0.0 s; depth, ir, poses, scene, distance_m>
    """
    with output_folder(Path(folder), replaces=(*MEMBERS, *OURS)) as partial:
        fill_simulation(partial, simulation)


def fill_simulation(folder: Path, simulation: Simulation) -> list[str]:
    """The same into a folder that is being made; what the sensor will not see, one sentence each."""
    missed = check_sight(simulation)
    telemetry = simulation.telemetry if len(simulation.telemetry) > 1 else None
    content, mesh = _scene(simulation)
    frames = each(simulation.frames(), "simulating", len(simulation))
    fill_recording(folder, simulation.camera, frames, simulation.stated, telemetry, content)
    write_mesh(folder / "scene.ply", mesh)
    if simulation.scene.board is not None:
        _write_json(folder / "board.json", simulation.scene.board.file())
    _write_truth(folder / "truth", simulation)
    return missed


def _scene(simulation: Simulation) -> tuple[dict[str, Any], Mesh]:
    """The content of `scene.json` and the mesh it names: one reflectance, or grey vertex colours."""
    scene, mesh = simulation.scene, simulation.mesh
    content: dict[str, Any] = {"name": scene.name, "mesh": "scene.ply"}
    reflectance = mesh.scalars["reflectance"]
    kept = {name: values for name, values in mesh.scalars.items() if name != "reflectance"}
    if np.ptp(reflectance) == 0:
        content["reflectance"] = round(float(reflectance[0]), 6)
        mesh = replace(mesh, colors=None, scalars=kept)
    else:
        grey = np.rint(255 * reflectance).astype(np.uint8)
        mesh = replace(mesh, colors=np.repeat(grey[:, None], 3, axis=1), scalars=kept)
    if scene.poses is not None:
        poses = scene.poses
        content["poses"] = {"source": poses.source, "sigma_m": poses.sigma_m, "sigma_rad": poses.sigma_rad}
    return content | {"ambient_lux": scene.ambient_lux}, mesh


def _write_truth(folder: Path, simulation: Simulation) -> None:
    folder.mkdir()
    write_trajectory(folder / "trajectory.txt", simulation.truth)
    mesh = simulation.truth_mesh
    if len(mesh.faces):
        write_mesh(folder / "mesh.ply", replace(mesh, scalars={}))
    write_camera(folder / "camera.json", simulation.sensor.true_camera(simulation.camera))
    write_sensor(folder / "sensor.json", simulation.sensor)
    content: dict[str, Any] = {"scene": simulation.scene.name, "sensor": simulation.sensor.name}
    content |= {"seed": simulation.seed, "fusion": __version__}
    table = simulation.scene.course.turntable
    if table is not None:
        content["axis_point"], content["axis_direction"] = list(table.axis_point), list(table.axis_direction)
        content["turned_deg"] = simulation.turned_deg.tolist()
    _write_json(folder / "truth.json", content)


def _write_json(path: Path, content: object) -> None:
    path.write_text(json_text(content) + "\n", encoding="utf-8")
