"""The demo's recording: an owl on a turntable, as a Kinect v2 indoors would see it, and the truth beside it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.files.output.publish import output_folder
from fusion.geometry.camera import Camera, Principle
from fusion.mesh.mesh import Mesh
from fusion.progress import each
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.scene.course import looking_at, turning
from fusion.simulation.scene.scene import Part, Scene
from fusion.simulation.scene.shapes import Points, box, disc, joined, sheet
from fusion.simulation.scene.turntable import Turntable, TurntableErrors
from fusion.simulation.simulate import Simulation, simulate

# intrinsics near those of a 640 x 480 depth camera, with a clearly visible lens
CAMERA = Camera(
    width=640,
    height=480,
    fx=577.3,
    fy=578.9,
    cx=322.6,
    cy=237.8,
    distortion=(0.062, -0.14, 0.0006, -0.0004, 0.03),
    depth_scale=5000.0,
    principle=Principle.TIME_OF_FLIGHT,
    sensor="simulated time of flight, noise of a Kinect v2 indoors",
)
OBJECT_AT = np.array([0.012, -0.008, 0.0])  # beside the axis, as people place things
PLATE_TOP = 0.0  # [m]
TABLE_TOP = -0.035  # [m]


def demo_scene(frames: int = 72, turns: float = 1.2) -> Scene:
    """The owl on a plate of 30 cm, a table and a wall behind it, seen from 0.75 m."""
    errors = TurntableErrors(uneven_sd_deg=0.1, slip_frame=2 * frames // 3, slip_deg=1.5)
    table = Turntable(degrees_per_frame=360.0 * turns / max(frames, 1), frames=frames, errors=errors)
    return Scene(
        name="demo",
        parts=(
            Part(demo_truth(), turns=True),
            Part(plate(), turns=True, scanned=False),
            *(Part(mesh, scanned=False) for mesh in surroundings()),
        ),
        course=turning(table, looking_at(np.array([0.66, 0.06, 0.38]), np.array([0.0, 0.0, 0.085]))),
        camera=CAMERA,
        poses=None,  # finding them is the point
        color=True,
        edge_lost=0.4,  # guess: the software of most sensors throws doubtful edge pixels away
    )


def demo_sensor() -> Sensor:
    """A Kinect v2 that was calibrated: the preset's own errors are taken as exactly known, and can be undone."""
    usual = preset("kinect-v2-indoors")
    return replace(usual, name="kinect-v2-indoors, calibrated", sensor=CAMERA.sensor, std={}, left_out=())


def demo_truth() -> Mesh:
    """The owl where it stands on the plate at frame 0 (world frame = object frame)."""
    owl = demo_object()
    return Mesh(owl.vertices + OBJECT_AT, owl.faces, owl.normals, owl.colors)


def write_demo_recording(folder: Path | str, seed: int = 0, frames: int = 72, turns: float = 1.2) -> Path:
    """Simulate the demo: `recording/`, its `sensor.json`, `truth.ply`, `truth_poses.txt` (camera in object frame).

    Returns:
        The folder of the recording.
    """
    with output_folder(Path(folder)) as partial:
        fill_demo_recording(partial, seed, frames, turns)
    return Path(folder) / "recording"


def fill_demo_recording(folder: Path, seed: int = 0, frames: int = 72, turns: float = 1.2) -> Path:
    """The same into a folder that is being made."""
    from fusion.mesh.files import write_mesh
    from fusion.recording.native.trajectory_file import write_trajectory
    from fusion.recording.writing.write import fill_recording
    from fusion.sensor.files.sensor_file import write_sensor

    simulation: Simulation = simulate(demo_scene(frames, turns), demo_sensor(), seed)
    recording = folder / "recording"
    recording.mkdir()
    frames_made = each(simulation.frames(), "simulating", len(simulation))
    fill_recording(recording, simulation.camera, frames_made, telemetry=simulation.telemetry)
    write_sensor(folder / "sensor.json", simulation.sensor)
    write_mesh(folder / "truth.ply", demo_truth())
    write_trajectory(folder / "truth_poses.txt", simulation.truth)
    return recording


def plate() -> Mesh:
    """A plate of 30 cm whose top lies just below z = 0, with a scale along its rim."""
    return disc(0.15, -0.012, PLATE_TOP - 0.0005, _plate_colors)


def surroundings() -> tuple[Mesh, ...]:
    """Table, wall, a tin and a case behind the turntable, which stand still."""
    x, y, z = np.eye(3)
    table = sheet(-0.55 * x - 0.9 * y + TABLE_TOP * z, 1.0 * x, 1.8 * y, _wood)
    wall = sheet(-0.55 * x - 1.2 * y - 0.5 * z, 2.4 * y, 1.8 * z, _wallpaper)
    tin = disc(0.035, 0.0, 0.11, lambda p: np.tile([70, 120, 80], (len(p), 1)))
    tin = Mesh(tin.vertices + np.array([-0.32, 0.34, TABLE_TOP]), tin.faces, colors=tin.colors)
    case = box((-0.42, -0.5, TABLE_TOP), (-0.24, -0.3, TABLE_TOP + 0.14), (150, 110, 90))
    foot = disc(0.06, TABLE_TOP, -0.012, lambda p: np.tile([60, 60, 64], (len(p), 1)))
    return (joined((table, wall, tin, case, foot)),)


def _plate_colors(p: Points) -> Points:
    """Light grey with a scale of unequal marks along the rim."""
    angle, radius = np.arctan2(p[:, 1], p[:, 0]), np.hypot(p[:, 0], p[:, 1])
    color = np.tile([205.0, 205.0, 210.0], (len(p), 1))
    sector = np.floor((angle + np.pi) / (2 * np.pi) * 36)
    color[(radius > 0.132) & (sector % 2 == 0)] = [60, 62, 70]
    color[(radius > 0.132) & (sector == 5)] = [200, 60, 50]
    return color


def _wood(p: Points) -> Points:
    grain = 0.5 + 0.5 * np.sin(p[:, 0] * 90 + 4 * np.sin(p[:, 1] * 5))
    return np.array([150.0, 112.0, 78.0]) + 30.0 * grain[:, None]


def _wallpaper(p: Points) -> Points:
    stripe = (np.floor(p[:, 1] * 12) % 2)[:, None]
    return np.array([178.0, 186.0, 192.0]) + 14.0 * stripe
