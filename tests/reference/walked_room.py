"""A small furnished room, printed all over, in which a camera turns all the way round: it ends where it began."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.geometry.camera import Camera
from fusion.geometry.pose import pose
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame, Recording
from fusion.simulation.rendering.render import Channels, RayCaster
from fusion.simulation.scene.shapes import box, joined

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
STEP = np.deg2rad(5)  # from frame to frame
SIGMA = 0.003  # [m] at 1 m, growing with the square of the distance


@dataclass(frozen=True)
class WalkedRoom:
    """Frames of a walk; `bare` has nothing but walls to one side, the print stays."""

    bare: bool = False
    camera: Camera = CAMERA
    sigma: float = SIGMA

    @cached_property
    def caster(self) -> RayCaster:
        return RayCaster(furnished(self.bare))

    def recording(self, poses, colored=True, blank=()) -> Recording:
        """Frames at poses (n, 4, 4), those in `blank` without any depth."""
        stamps = 5.0 + np.arange(len(poses)) / 10

        def load(index: int) -> Frame:
            view = self.caster.view(self.camera, poses[index], Channels(color=False))
            points = self.camera.points(np.nan_to_num(view.depth)) @ poses[index][:3, :3].T + poses[index][:3, 3]
            rng = np.random.default_rng(index)
            depth = view.depth + self.sigma * view.depth**2 * rng.standard_normal(view.depth.shape)
            if index in blank:
                depth[:] = np.nan
            return Frame(index, float(stamps[index]), depth.astype(np.float32), printed(points) if colored else None)

        return Recording(Path("made"), "made", self.camera, stamps, load)


def furnished(bare: bool) -> Mesh:
    """A room of 3.6 x 3.2 x 2.2 m about the origin, y down, with boxes along its walls."""
    rng = np.random.default_rng(8)
    x, y, z = 1.8, 1.1, 1.6
    walls = [
        box((-x - 0.1, y, -z - 0.1), (x + 0.1, y + 0.1, z + 0.1), (90, 90, 90)),
        box((-x - 0.1, -y - 0.1, -z - 0.1), (x + 0.1, -y, z + 0.1), (90, 90, 90)),
        box((-x - 0.1, -y, -z), (-x, y, z), (90, 90, 90)),
        box((x, -y, -z), (x + 0.1, y, z), (90, 90, 90)),
        box((-x, -y, -z - 0.1), (x, y, -z), (90, 90, 90)),
        box((-x, -y, z), (x, y, z + 0.1), (90, 90, 90)),
    ]
    things = []
    for angle in np.linspace(0, 2 * np.pi, 22, endpoint=False) + rng.uniform(-0.1, 0.1, 22):
        if bare and 2.0 < angle < 3.6:
            continue
        size = rng.uniform([0.2, 0.3, 0.2], [0.5, 0.9, 0.4])
        across = np.array([np.sin(angle) * (x - 0.2), np.cos(angle) * (z - 0.2)])
        across /= max(abs(across[0]) / (x - 0.2), abs(across[1]) / (z - 0.2))
        centre = (across[0], rng.choice([y - size[1] / 2, rng.uniform(-0.6, 0.4)]), across[1])
        part = box(tuple(-size / 2), tuple(size / 2), (200, 80, 80))
        turn = Rotation.from_rotvec([0, rng.uniform(0, 3), 0]).as_matrix()
        things.append(Mesh(part.vertices @ turn.T + centre, part.faces, colors=part.colors))
    return joined(walls + things)


def printed(points):
    """Colours (h, w, 3) uint8 of points (h, w, 3): cells of 25 and 6 cm, each of a random tone."""
    large, small = (_tone(np.floor(points / size + 0.3).astype(np.int64)) for size in (0.25, 0.06))
    return np.repeat(np.round(30 + 120 * large + 90 * small).astype(np.uint8)[..., None], 3, axis=2)


def _tone(cell):
    mixed = cell[..., 0] * 73856093 ^ cell[..., 1] * 19349663 ^ cell[..., 2] * 83492791
    mixed = (mixed ^ (mixed >> 13)) * 1274126177
    return ((mixed ^ (mixed >> 16)) & 1023) / 1023


def round_walk(turn: float, start: float = 0.0, step: float = STEP):
    """Poses (n, 4, 4) of a camera in a hand that walks a small circle through a turn [rad] and looks outwards."""
    angles = start + np.arange(0, turn, step)
    poses = []
    for k, angle in enumerate(angles):
        sway = 0.02 * np.array([np.sin(0.7 * k), np.sin(0.5 * k + 1), np.sin(0.9 * k)])
        look = Rotation.from_rotvec([0, angle, 0]) * Rotation.from_rotvec(sway)
        centre = 0.45 * np.array([np.sin(angle), 0, np.cos(angle)]) + 0.01 * np.sin([0.6 * k, 0.8 * k, 0.4 * k])
        poses.append(pose(look.as_matrix(), centre))
    return np.stack(poses)


def truth_of(recording, poses) -> Trajectory:
    return Trajectory(recording.timestamps, poses)
