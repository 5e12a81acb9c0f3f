"""Stage: what is known of the scene of one recording: a mesh and poses, or a simulation of it."""

from dataclasses import dataclass, replace
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.scene.motion import twists_of
from fusion.discrepancy.observe.scene.table import LoggedTable, table_of
from fusion.discrepancy.observe.scene.wall import FREE_RAD, LASER_M, wall_of
from fusion.discrepancy.simulated import Match
from fusion.errors import RecordingError
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import read_mesh
from fusion.recording.native.scene_file import scene_mesh, stated_scene
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.render import RayCaster

WALL_M = 0.0003  # guess: how far a wall that was chosen for calibration is from flat
RECONSTRUCTED_M = 0.005  # guess: what usual sensors measure wrong, and a mesh made of their frames holds
NOMINAL = (0.005, 0.01)  # [m], [rad] guess: how far a pose may be off that nobody measured


@dataclass(frozen=True)
class KnownScene:
    """What is known of the scene of one recording."""

    recording: Recording  # with its poses
    place: int  # 0, 1, ... in the order given.
    caster: RayCaster | None  # the mesh, ready to be seen; in the world frame. None where a simulation stands for it.
    # sigma_m, sigma_rad: standard deviation of a common error of all its poses, per axis
    sigma_m: float
    sigma_rad: float
    mesh_sigma_m: float | None  # how far the real surface may be from the mesh; None where nobody said
    shape: str = ""  # fingerprint of the mesh file: recordings of one target share its errors
    table: LoggedTable | None = None  # the turntable on which everything stands; None where nothing turns
    # (n, 6) motion of the camera at every frame, see `twists_of`; None where a simulation stands for it
    twists: NDArray[np.float64] | None = None
    # the simulation of the recording and the sensor model that goes with it; None where there is a mesh
    simulated: tuple[Match, Sensor] | None = None
    # its poses were found in images of this camera, so that they are as wrong as the camera is
    placed_by_images: bool = False
    reconstructed: bool = False  # the mesh was made of recordings of this sensor, and holds errors of its own


def stage_of(recording: Recording, place: int) -> KnownScene:
    """The known scene of a recording; RecordingError when mesh or poses are missing."""
    scene, mesh = stated_scene(recording), scene_mesh(recording)
    wall = wall_of(recording) if mesh is None else None
    if wall is not None:
        # each wall is one of its own: what it is not flat is not known to come again
        shape = f"wall {recording.path}"
        return KnownScene(wall.recording, place, RayCaster(wall.mesh), LASER_M, FREE_RAD, WALL_M, shape)
    if mesh is None:
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
    caster = RayCaster(read_mesh(mesh))
    poses, reconstructed = scene.stated_poses, scene.mesh_from == "reconstruction"
    return KnownScene(
        recording,
        place,
        caster,
        _or(poses.sigma_m, NOMINAL[0]),
        _or(poses.sigma_rad, NOMINAL[1]),
        RECONSTRUCTED_M if scene.mesh_sigma_m is None and reconstructed else scene.mesh_sigma_m,
        sha256(mesh.read_bytes()).hexdigest(),
        table_of(recording),
        twists_of(recording),
        placed_by_images=poses.from_ == "images",
        reconstructed=reconstructed,
    )


def _or(value: float | None, usual: float) -> float:
    return usual if value is None else value


def simulated_stage(match: Match, place: int, sensor: Sensor) -> KnownScene:
    """A recording whose prediction is a simulation; poses that are not known are the same while the simulation is."""
    recording = match.recording
    scene = stated_scene(recording)
    if recording.poses is None or not recording.poses.valid.any():
        poses = np.tile(np.eye(4), (len(recording), 1, 1))
        recording = replace(recording, poses=Trajectory(recording.timestamps, poses))
    return KnownScene(
        recording,
        place,
        None,
        _or(scene.stated_poses.sigma_m, NOMINAL[0]),
        _or(scene.stated_poses.sigma_rad, NOMINAL[1]),
        scene.mesh_sigma_m or 0.0,
        simulated=(replace(match, recording=recording), sensor),
    )
