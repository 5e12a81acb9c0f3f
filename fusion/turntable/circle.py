"""The circle post-pass of Pagliari et al. 2014: fit a plane and a circle to the camera's centres, move them onto it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.trajectory import Trajectory

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Circle:
    """A circle in space."""

    centre: Array  # (3,) [m]
    normal: Array  # (3,) unit vector
    radius: float  # [m]
    # radial_rms, axial_rms: how far the fitted centres lie from it, in its plane and across [m]
    radial_rms: float
    axial_rms: float

    def basis(self) -> Array:
        """(2, 3) unit vectors that span the plane, right-handed with the normal."""
        first = np.cross(self.normal, np.eye(3)[int(np.argmin(np.abs(self.normal)))])
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(self.normal, first)])

    def angles(self, points: Array) -> Array:
        """(n,) angle of points (n, 3) about the normal [rad]."""
        flat = (points - self.centre) @ self.basis().T
        return np.arctan2(flat[:, 1], flat[:, 0])

    def at(self, angles: Array) -> Array:
        """(n, 3) points of the circle at angles (n,) [rad]."""
        flat = np.column_stack([np.cos(angles), np.sin(angles)]) * self.radius
        return np.asarray(self.centre + flat @ self.basis())


def fit_circle(points: Array) -> Circle:
    """Plane by total least squares, then the circle in it by Kasa's start and geometric least squares.

    Raises:
        TrackingError: fewer than three points, or points on a line.
    """
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 3:
        raise TrackingError("no circle through the camera centres", found=f"{len(points)} poses", expected="3 or more")
    mean = points.mean(axis=0)
    _, size, axes = np.linalg.svd(points - mean, full_matrices=False)
    if size[1] < 1e-6 * max(size[0], 1e-9):
        raise TrackingError("no circle through the camera centres", found="centres on a line", expected="an arc")
    flat = (points - mean) @ axes[:2].T
    A = np.column_stack([2 * flat, np.ones(len(flat))])
    middle = np.linalg.lstsq(A, (flat**2).sum(axis=1), rcond=None)[0][:2]
    for _ in range(20):  # Gauss-Newton on the distances to the circle
        arm = flat - middle
        distance = np.linalg.norm(arm, axis=1)
        J = np.column_stack([-arm / distance[:, None], -np.ones(len(arm))])
        radius = distance.mean()
        step = np.linalg.lstsq(J, -(distance - radius), rcond=None)[0]
        middle = middle + step[:2]
        if np.abs(step[:2]).max() < 1e-9:
            break
    distance = np.linalg.norm(flat - middle, axis=1)
    normal = np.cross(axes[0], axes[1])
    axial = (points - mean) @ normal
    return Circle(
        mean + middle @ axes[:2],
        normal,
        float(distance.mean()),
        float(np.sqrt(np.mean((distance - distance.mean()) ** 2))),
        float(np.sqrt(np.mean(axial**2))),
    )


def onto_circle(trajectory: Trajectory, commanded: Array | None = None) -> tuple[Trajectory, Circle]:
    """Move every camera centre onto the fitted circle; rotations stay as they are (the paper's post-pass).

    Args:
        trajectory: tracked poses in the object's frame.
        commanded: (n,) table angles [rad]: centres are then placed by angle (offset and direction fitted), otherwise
            each goes to the nearest point of the circle.
    """
    valid = trajectory.valid
    circle = fit_circle(trajectory.centres[valid])
    angles = np.unwrap(circle.angles(trajectory.centres[valid]))
    if commanded is not None:
        told = commanded[valid]
        sign = 1.0 if np.corrcoef(told, angles)[0, 1] >= 0 else -1.0
        angles = sign * told + np.median(angles - sign * told)
    poses = trajectory.poses.copy()
    poses[np.flatnonzero(valid), :3, 3] = circle.at(angles)
    return Trajectory(trajectory.timestamps, poses), circle
