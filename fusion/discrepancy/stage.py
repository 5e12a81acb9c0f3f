"""Stage: what is known of the scene of one recording: a mesh and poses, or a simulation of it."""

from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from fusion.discrepancy.simulated import Match
from fusion.discrepancy.table import Table, table_of
from fusion.discrepancy.wall import wall_of
from fusion.errors import RecordingError
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import read_mesh
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.simulation.render import RayCaster

WALL_M = 0.0003  # guess: how far a wall that was chosen for calibration is from flat
RECONSTRUCTED_M = 0.005  # guess: what usual sensors measure wrong, and a mesh made of their frames holds
NOMINAL = (0.005, 0.01)  # [m], [rad] guess: how far a pose may be off that nobody measured


@dataclass(frozen=True)
class Stage:
    """What is known of the scene of one recording.

    Attributes:
        recording: with its poses.
        place: 0, 1, ... in the order given.
        caster: the mesh, ready to be seen; in the world frame. None where a simulation stands for it.
        sigma_m, sigma_rad: standard deviation of a common error of all its poses, per axis.
        mesh_sigma_m: how far the real surface may be from the mesh.
        shape: fingerprint of the mesh file: recordings of one target share its errors.
        table: the turntable on which everything stands; None where nothing turns.
        simulated: the simulation of the recording and the sensor model that goes with it; None where there is a mesh.
        placed_by_images: its poses were found in images of this camera, so that they are as wrong as the camera is.
        reconstructed: the mesh was made of recordings of this sensor, and holds errors of its own.
    """

    recording: Recording
    place: int
    caster: RayCaster | None
    sigma_m: float
    sigma_rad: float
    mesh_sigma_m: float
    shape: str = ""
    table: Table | None = None
    simulated: tuple[Match, Sensor] | None = None
    placed_by_images: bool = False
    reconstructed: bool = False


def stage_of(recording: Recording, place: int) -> Stage:
    """The known scene of a recording; RecordingError when mesh or poses are missing."""
    mesh = recording.scene.get("mesh")
    wall = None if mesh else wall_of(recording)
    if wall is not None:
        # each wall is one of its own: what it is not flat is not known to come again
        shape = f"wall {recording.path}"
        return Stage(wall.recording, place, RayCaster(wall.mesh), wall.sigma_m, wall.sigma_rad, WALL_M, shape)
    if not mesh:
        raise RecordingError(
            "the scene of the recording is not known",
            recording.path,
            "no scene.json with a mesh",
            'scene.json with {"mesh": "scene.ply"}, or a flat wall with distance_m in telemetry.csv',
            "add the mesh of what stood before the camera",
        )
    if recording.poses is None or not recording.poses.valid.any():
        raise RecordingError(
            "the poses of the recording are not known", recording.path, expected="groundtruth.txt", do="add the poses"
        )
    about = recording.scene.get("poses")
    about = about if isinstance(about, dict) else {}
    path = Path(recording.path) / str(mesh)
    caster = RayCaster(read_mesh(path))
    reconstructed = _told(recording.scene, "mesh_from", "reconstruction", recording)
    return Stage(
        recording,
        place,
        caster,
        number_of(about, "sigma_m", NOMINAL[0], recording),
        number_of(about, "sigma_rad", NOMINAL[1], recording),
        number_of(recording.scene, "mesh_sigma_m", RECONSTRUCTED_M if reconstructed else 0.0, recording),
        sha256(path.read_bytes()).hexdigest(),
        table_of(recording),
        placed_by_images=_told(about, "from", "images", recording),
        reconstructed=reconstructed,
    )


def _told(about: dict[str, Any], key: str, word: str, recording: Recording) -> bool:
    """True where `scene.json` says this word under a key; RecordingError when it says what else."""
    told = about.get(key)
    if told not in (None, word):
        raise RecordingError(
            f'"{key}" in scene.json cannot be used', recording.path, repr(told), f'"{word}", or nothing'
        )
    return bool(told == word)


def number_of(given: dict[str, Any], name: str, usual: float, recording: Recording, most: float = 10.0) -> float:
    """A number of `scene.json` from 0 on; the usual one where it is not said."""
    value = given.get(name, usual)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < most:
        raise RecordingError(f"{name} of scene.json cannot be used", recording.path, repr(value), f"0 to {most:g}")
    return float(value)


def simulated_stage(match: Match, place: int, sensor: Sensor) -> Stage:
    """A recording whose prediction is a simulation; poses that are not known are the same while the simulation is."""
    recording = match.recording
    about = recording.scene.get("poses")
    about = about if isinstance(about, dict) else {}
    if recording.poses is None or not recording.poses.valid.any():
        poses = np.tile(np.eye(4), (len(recording), 1, 1))
        recording = replace(recording, poses=Trajectory(recording.timestamps, poses))
    return Stage(
        recording,
        place,
        None,
        number_of(about, "sigma_m", NOMINAL[0], recording),
        number_of(about, "sigma_rad", NOMINAL[1], recording),
        number_of(recording.scene, "mesh_sigma_m", 0.0, recording),
        simulated=(replace(match, recording=recording), sensor),
    )
