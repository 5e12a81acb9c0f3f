"""Two sets of small inputs, of the same cameras and sizes, for calls of every public entry point."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

import fusion

CAMERA = fusion.Camera(96, 72, 86.0, 86.0, 48.0, 36.0, depth_scale=5000.0, principle="itof")
LARGER = replace(CAMERA, width=200, height=150, fx=180.0, fy=180.0, cx=100.0, cy=75.0)
DISTANCES = (0.6, 0.9, 1.3)  # [m] of walls
POINTS = np.random.default_rng(7).normal(0, 0.05, (500, 3)) + np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Inputs:
    """What one thread works with.

    Attributes:
        folder: `ball.ply`, `sensor.json`, and the recordings, which are made when they are asked for.
        seed: another number for each set.
        depth: (h, w) [m] of CAMERA.
        ball: a mesh that is no ball.
        sensor: that the recordings were made with.
    """

    folder: Path
    seed: int
    depth: NDArray[np.float32]
    ball: fusion.Mesh
    sensor: fusion.Sensor

    def place(self, name: str) -> Path:
        """Folder of the recording `wall_0`, ..., `room`, `turning` or `board`."""
        path = self.folder / name
        if not path.exists():
            scene, settings, sensor, camera = self._made_by(name)
            scene = replace(fusion.built_in(scene, settings), camera=camera)
            fusion.write_simulation(path, fusion.simulate(scene, sensor, self.seed))
        return path

    def walls(self, count: int) -> list[fusion.Recording]:
        """Recordings of walls at several distances."""
        return [fusion.open_recording(self.place(f"wall_{n}")) for n in range(count)]

    def _made_by(self, name: str) -> tuple[str, dict[str, Any], fusion.Sensor, fusion.Camera]:
        if name.startswith("wall_"):
            distance = DISTANCES[int(name[5:])] + 0.02 * self.seed
            return "wall", {"distance_m": distance, "frames": 4}, self.sensor, CAMERA
        if name == "room":
            return "room", {"frames": 4, "sweep_deg": 3 + self.seed}, self.sensor, CAMERA
        if name == "turning":
            turns = 26 * (15 - self.seed / 4) / 360
            return "turntable", {"frames": 26, "turns": turns}, fusion.Sensor(principle="itof"), CAMERA
        return "checkerboard", {"frames": 6}, self.sensor, LARGER


def made(folder: Path, seed: int) -> Inputs:
    """Another set for each seed."""
    folder.mkdir(parents=True)
    sensor = fusion.read_sensor("kinect-v2-indoors")
    fusion.write_sensor(folder / "sensor.json", sensor)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    depth = (1 + 0.1 * np.sin(u / (9 + seed)) + 0.05 * np.cos(v / (7 + seed))).astype(np.float32)
    depth[:, 30 + 5 * seed : 33 + 7 * seed] = np.nan
    shape = trimesh.creation.icosphere(3, 0.05)
    points = np.asarray(shape.vertices) * [1.0, 1.2, 1.4 + 0.1 * seed]
    ball = fusion.Mesh(points, np.asarray(shape.faces), colors=np.full((len(points), 3), 90 + seed, np.uint8))
    fusion.write_mesh(folder / "ball.ply", ball)
    return Inputs(folder, seed, depth, ball, sensor)
