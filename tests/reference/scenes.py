"""Analytic depth images: exact truth that shares no code with the volume."""

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse, pose


def look_at(eye, target):
    """Pose of a camera at `eye` that looks at `target`."""
    z = np.asarray(target, float) - eye
    z /= np.linalg.norm(z)
    side = (0.0, 0.0, 1.0) if abs(z[2]) < 0.95 else (1.0, 0.0, 0.0)
    x = np.cross(z, side)
    x /= np.linalg.norm(x)
    return pose(np.stack([x, np.cross(z, x), z], axis=1), eye)


def around(centre, distance):
    """26 poses around a point: the corners, edges and faces of a cube seen from its middle."""
    directions = [np.array(d) - 1.0 for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)]
    return [look_at(centre + distance * d / np.linalg.norm(d), centre) for d in directions]


def world_rays(camera: Camera, T):
    """Directions (h, w, 3) in the world of one metre of depth."""
    return np.dstack([camera.rays(), np.ones(camera.shape)]).astype(float) @ T[:3, :3].T


def sphere(camera: Camera, T, centre, radius):
    """Depth (h, w) of a sphere, NaN beside it."""
    d, o = world_rays(camera, T), T[:3, 3] - centre
    a, b, c = (d * d).sum(-1), d @ o, o @ o - radius**2
    under = b * b - a * c
    return np.where(under > 0, (-b - np.sqrt(np.maximum(under, 0))) / a, np.nan).astype(np.float32)


def plane(camera: Camera, T, point, normal):
    """Depth (h, w) of a plane, NaN where the ray does not meet it."""
    down = world_rays(camera, T) @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (point - T[:3, 3]) @ normal / down
    return np.where(np.isfinite(z) & (z > 0), z, np.nan).astype(np.float32)


def project_all(camera: Camera, T, points):
    """Pixels (n, 2) and depths (n,) of world points."""
    local = points @ inverse(T)[:3, :3].T + inverse(T)[:3, 3]
    return camera.project(local), local[:, 2]
