"""Where a colour camera was, to a part of a pixel: its print laid on what all views show together.

Poses come from depth: a shape that slides along itself leaves them open by some pixels of a colour camera, its place
beside the depth camera by more, and images are a little apart in time. Print tells (Zhou and Koltun, Color map
optimization for 3D reconstruction with consumer depth cameras, SIGGRAPH 2014).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.coloring.images import bilinear
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, exp, inverse, transform

STEPS = 5  # of Gauss and Newton
ALIKE = 20.0  # [counts] print that differs by more counts less (guess)
USUAL = 2.0  # [px] that a camera is off: how far a picture without print may drift (guess)
FARTHEST = 12.0  # [px] beyond, it is not the pose: left where it is (guess)
FEWEST, ENOUGH = 100, 5000  # points that a camera is settled by: six numbers need no more


def settled(
    camera: Camera, high: NDArray[np.float32], stated: Array, at: Array, points: Array, print_: NDArray[np.float32]
) -> Array:
    """`T_world_camera` (4, 4) at which the fine colours of an image fit.

    Args:
        camera: of the image.
        high: (h, w, 3) what is fine in the image [counts].
        stated: (4, 4) where the depth says that it was.
        at: (4, 4) from where it is sought.
        points: (k, 3) of the surface that it shows [m].
        print_: (k, 3) their fine colours from all views [counts].
    """
    if len(points) < FEWEST:
        return at
    every = -(-len(points) // ENOUGH)
    points, print_ = points[::every], print_[::every]
    across, down = np.gradient(high, axis=1), np.gradient(high, axis=0)
    T, local = at, transform(inverse(stated), points)
    start, near = camera.project(local), camera.fx / float(np.median(local[:, 2]))  # [px], [px/m]
    prior = np.diag(np.array([camera.fx] * 3 + [near] * 3) ** 2) / USUAL**2
    for _ in range(STEPS):
        local = transform(inverse(T), points)
        pixels = camera.project(local)
        away = print_ - bilinear(high, pixels)
        weight = 1 / (1 + (away / ALIKE) ** 2)
        J = _jacobian(local, camera, (bilinear(across, pixels), bilinear(down, pixels)))
        spread = max(float(np.average(away**2, weights=weight)), 1.0)
        information = np.einsum("kci,kc,kcj->ij", J, weight, J, optimize=True) / spread + prior
        pull = np.einsum("kci,kc->i", J, weight * away, optimize=True) / spread - prior @ twist_of(inverse(T) @ stated)
        T = T @ inverse(exp(np.linalg.solve(information, pull)))
    moved = np.linalg.norm(camera.project(transform(inverse(T), points)) - start, axis=1)
    return T if float(np.median(moved)) <= FARTHEST else stated


def without_common(poses: Array, stated: Array) -> Array:
    """Poses (n, 4, 4) less what all were moved by alike, seen from the cameras and seen from the world.

    The images do not tell it: print that lies elsewhere on the surface in all of them fits as well.
    """
    for from_world in (False, True):
        moved = [twist_of(T @ inverse(S) if from_world else inverse(S) @ T) for T, S in zip(poses, stated, strict=True)]
        common = inverse(exp(np.mean(moved, axis=0)))
        poses = np.stack([common @ T if from_world else T @ common for T in poses])
    return poses


def twist_of(T: Array) -> Array:
    """(6,) of a small motion (4, 4)."""
    return np.concatenate([Rotation.from_matrix(T[:3, :3]).as_rotvec(), T[:3, 3]])


def _jacobian(local: Array, camera: Camera, slope: tuple[NDArray[np.float32], NDArray[np.float32]]) -> Array:
    """(k, 3, 6) how colours change when points (k, 3) turn about and move along the camera's axes."""
    x, y, z = local.T
    zero = np.zeros_like(z)
    u = np.stack([camera.fx / z, zero, -camera.fx * x / z**2], axis=1)
    v = np.stack([zero, camera.fy / z, -camera.fy * y / z**2], axis=1)
    by_place = slope[0][..., None] * u[:, None] + slope[1][..., None] * v[:, None]
    return np.concatenate([np.cross(local[:, None], by_place), by_place], axis=2)
