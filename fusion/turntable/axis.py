"""The axis of a turntable and how points move about it."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.geometry import pose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """A directed line in the camera's frame."""

    point: Array  # (3,) a point on it [m]
    direction: Array  # (3,) unit vector, out of the plate (up)

    def turn(self, angle_rad: float) -> Array:
        """The pose (4, 4) that moves the object by an angle, right-handed about the direction."""
        return pose.about_axis(self.point, self.direction, angle_rad)

    def raised(self, height: float) -> "Axis":
        """The same with its point so much higher [m]."""
        return replace(self, point=self.point + height * self.direction)

    def turns(self, angles_rad: Array) -> Array:
        """The poses (n, 4, 4) of several turns (n,)."""
        T = np.tile(np.eye(4), (len(angles_rad), 1, 1))
        T[:, :3, :3] = Rotation.from_rotvec(np.multiply.outer(angles_rad, self.direction)).as_matrix()
        T[:, :3, 3] = self.point - T[:, :3, :3] @ self.point
        return T

    def across(self) -> Array:
        """(2, 3) two unit vectors perpendicular to the axis and to each other."""
        helper = np.eye(3)[int(np.argmin(np.abs(self.direction)))]
        first = np.cross(self.direction, helper)
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(self.direction, first)])

    def nearest_to(self, point: Array) -> "Axis":
        """The same line, with its point moved along it to where it is nearest to a given point (3,)."""
        along = float((np.asarray(point, float) - self.point) @ self.direction)
        return Axis(self.point + along * self.direction, self.direction)

    def moved(self, step: Array) -> "Axis":
        """The axis after a small change (4,): tilts [rad] about, and shifts [m] along, the two vectors of `across`."""
        across = self.across()
        tilt = step[0] * across[0] + step[1] * across[1]
        direction = pose.exp([*tilt, 0, 0, 0])[:3, :3] @ self.direction
        return Axis(self.point + step[2] * across[0] + step[3] * across[1], direction / np.linalg.norm(direction))

    def before_moved_camera(self, step: Array) -> "Axis":
        """The axis after tilts [rad] and shifts [m] (4,) of the camera along x and y of the object's frame."""
        T = pose.inverse(pose.exp([step[0], step[1], 0, step[2], step[3], 0]) @ self.object_frame())
        return Axis(T[:3, 3], T[:3, 2])

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance from the axis and height along it, each (n,) [m], of points (n, 3)."""
        # one column after the other: three values side by side cost NumPy four times as much
        offset = [points[:, k] - self.point[k] for k in range(3)]
        height = sum(o * d for o, d in zip(offset, self.direction, strict=True))
        square = sum((o - height * d) ** 2 for o, d in zip(offset, self.direction, strict=True))
        return np.sqrt(square), np.asarray(height)

    def object_frame(self) -> Array:
        """`T_object_camera` (4, 4): origin at the axis' point, z along the axis, x towards the camera."""
        towards = -self.point - (-self.point @ self.direction) * self.direction
        if np.linalg.norm(towards) < 1e-6 * max(1.0, float(np.linalg.norm(self.point))):
            towards = self.across()[0]
        x = towards / np.linalg.norm(towards)
        R = np.stack([x, np.cross(self.direction, x), self.direction])
        return pose.pose(R, -R @ self.point)


class Turns(NamedTuple):
    """What a table does: `axis` in the camera's frame, `angles` (n,) [rad] by which each view is turned about it."""

    axis: Axis
    angles: Array


def about_axis(axis: Axis, angles: Array, shifts: Array | None = None) -> Array:
    """The camera in the object's frame (n, 4, 4), NaN where the angle is NaN.

    Args:
        axis: about which the object turns.
        angles: (n,) [rad].
        shifts: (n, 2) across the axis [m], where a hand moved the object too (see `Motion`).
    """
    T_object_camera = axis.object_frame()
    poses = np.full((len(angles), 4, 4), np.nan)
    moved = np.zeros((len(angles), 2)) if shifts is None else shifts
    for i in np.flatnonzero(np.isfinite(angles)):
        back = axis.turn(-float(angles[i]))
        back[:3, 3] -= back[:3, :3] @ (moved[i] @ axis.across())
        poses[i] = T_object_camera @ back
    return poses
