"""How fast what a pixel sees moves against the camera."""

import cv2
import numpy as np

from fusion.geometry.pose import Array, inverse
from fusion.sensor.view import Image, View
from fusion.simulation.rendering.casting import CastBodies, directions


def twist_between(T_world_before: Array, T_world_after: Array, seconds: float) -> Array:
    """The steady motion (6,) of a body between two poses: rotation [rad/s], velocity at the world's origin [m/s].

    Constant in the world frame, so that it leads exactly from one pose to the other (half a turn at most).
    """
    motion = T_world_after @ inverse(T_world_before)
    rotation = np.asarray(cv2.Rodrigues(np.ascontiguousarray(motion[:3, :3]))[0], np.float64).reshape(3)
    return np.concatenate([rotation, _steady(rotation) @ motion[:3, 3]]) / seconds


def velocity_of(view: View, stage: CastBodies, body: np.ndarray, camera_twist: Array | None = None) -> Image:
    """Velocity (h, w, 3) [m/s] of the surface against the camera, in the camera frame; NaN where there is none.

    Args:
        body: (h, w) which body of the stage a pixel sees.
        camera_twist: (6,) of the camera in the world frame; None: it stands still.
    """
    assert view.depth is not None
    rest = np.zeros(6)
    own = rest if camera_twist is None else np.asarray(camera_twist, float)
    twists = [(rest if b.twist is None else np.asarray(b.twist, float)) - own for b in stage.bodies]
    R, origin = stage.T_world_camera[:3, :3], stage.T_world_camera[:3, 3]
    velocity = np.zeros((*view.depth.shape, 3), np.float32)
    velocity[np.isnan(view.depth)] = np.nan
    rays = directions(view.camera).reshape(velocity.shape)
    for index, twist in enumerate(twists):
        if twist.any():
            spin, drift = R.T @ twist[:3], R.T @ (twist[3:] + np.cross(twist[:3], origin))
            mine = body == index
            velocity[mine] = np.cross(spin, rays[mine] * view.depth[mine, None]) + drift
    return velocity


def _steady(rotation: Array) -> Array:
    """(3, 3) from the displacement of the origin to its velocity: the inverse of the left Jacobian of SO(3)."""
    angle = np.linalg.norm(rotation)
    x, y, z = rotation
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-6:
        return np.eye(3) - K / 2
    half = angle / 2
    return np.eye(3) - K / 2 + (1 - half / np.tan(half)) / angle**2 * K @ K
