"""A corner of a room with things in it, seen by a small camera that moves."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap, point_map
from fusion.geometry.pose import exp
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined

CAMERA = Camera(160, 120, 144.3, 144.7, 80.3, 59.1, distortion=(0.06, -0.14))
SIGMA = 0.002  # [m], of the depth noise


@dataclass(frozen=True)
class Room:
    """A mesh that can be seen as a point map, with or without noise."""

    caster: RayCaster

    def depth(self, T_world_camera, seed=None):
        depth = self.caster.view(CAMERA, T_world_camera).depth.astype(np.float32)
        if seed is not None:
            depth += np.random.default_rng(seed).normal(0, SIGMA, depth.shape).astype(np.float32)
        return depth

    def frame(self, T_world_camera, seed=None) -> PointMap:
        return point_map(self.depth(T_world_camera, seed), CAMERA, SIGMA)

    def model(self, T_world_camera) -> PointMap:
        """The true surface, as a volume would show it."""
        view = self.caster.view(CAMERA, T_world_camera)
        points = CAMERA.points(view.depth)
        return PointMap(CAMERA, points, view.normals.astype(np.float32), np.zeros_like(view.depth))


def room_mesh() -> Mesh:
    """Two walls and a floor of a room with boxes on the floor and on the wall, 1 to 2 m before a camera at the origin.

    The boxes are turned, so that from everywhere near the origin faces of all directions are seen well.
    """
    return joined(
        [
            box((-2.5, 0.5, 0.0), (2.5, 0.6, 2.1), (90, 90, 90)),  # the floor: y points down
            box((-2.5, -2.5, 2.0), (2.5, 0.6, 2.1), (150, 150, 150)),
            box((-1.2, -2.5, 0.0), (-1.1, 0.6, 2.1), (200, 200, 200)),
            turned((-0.45, 0.3, 1.4), (0.3, 0.4, 0.3), (0.1, 0.7, 0.0)),
            turned((0.25, 0.2, 1.6), (0.3, 0.6, 0.2), (0.0, -0.6, 0.2)),
            turned((0.6, 0.4, 1.1), (0.25, 0.25, 0.3), (0.3, 0.8, 0.1)),
            turned((-0.6, -0.7, 1.9), (0.4, 0.4, 0.4), (0.6, 0.6, 0.0)),
            turned((0.1, -0.5, 1.9), (0.3, 0.3, 0.3), (0.7, 0.3, 0.5)),
            turned((0.8, -0.6, 1.8), (0.4, 0.4, 0.4), (0.5, -0.7, 0.2)),
        ]
    )


def turned(centre, size, rotation) -> Mesh:
    """A box of a size (3,) [m] about a centre, turned by a rotation vector [rad]."""
    half = np.array(size) / 2
    mesh = box(tuple(-half), tuple(half), (200, 80, 80))
    moved = mesh.vertices @ Rotation.from_rotvec(rotation).as_matrix().T + centre
    return Mesh(moved, mesh.faces, colors=mesh.colors)


def sway(t: float):
    """A hand-held motion (4, 4): some centimetres and degrees, the start at t = 0 is the identity."""
    turn = 0.12 * np.array([np.sin(1.3 * t), np.sin(0.9 * t), 0.5 * np.sin(1.7 * t)])
    shift = np.array([0.08 * np.sin(t), 0.05 * np.sin(0.8 * t), 0.10 * np.sin(0.6 * t)])
    return exp(np.concatenate([turn, shift]))
