"""The axis of a turntable and how points move about it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """A directed line in the camera's frame.

    Attributes:
        point: (3,) a point on it [m].
        direction: (3,) unit vector, out of the plate (up).
    """

    point: Array
    direction: Array

    def turn(self, angle_rad: float) -> Array:
        """The pose (4, 4) that moves the object by an angle, right-handed about the direction."""
        return pose.about_axis(self.point, self.direction, angle_rad)

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

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance from the axis and height along it, each (n,) [m], of points (n, 3)."""
        offset = points - self.point
        height = offset @ self.direction
        return np.linalg.norm(offset - height[:, None] * self.direction, axis=1), height

    def object_frame(self) -> Array:
        """`T_object_camera` (4, 4): origin at the axis' point, z along the axis, x towards the camera."""
        towards = -self.point - (-self.point @ self.direction) * self.direction
        if np.linalg.norm(towards) < 1e-6 * max(1.0, float(np.linalg.norm(self.point))):
            towards = self.across()[0]
        x = towards / np.linalg.norm(towards)
        R = np.stack([x, np.cross(self.direction, x), self.direction])
        return pose.pose(R, -R @ self.point)


def jacobian(axis: Axis, angle_rad: float, points: Array, normals: Array) -> Array:
    """Derivatives (n, 5) of n . (turn(angle) p) in the angle [1/rad] and the four steps of `Axis.moved`.

    Args:
        axis, angle_rad: the turn.
        points: (n, 3) p after the turn [m].
        normals: (n, 3).
    """
    R = axis.turn(angle_rad)[:3, :3]
    arm = points - axis.point
    back = arm @ R  # the arm before the turn
    columns = [np.einsum("ij,ij->i", normals, np.cross(axis.direction, arm))]
    turned_normals = normals @ R
    for omega in axis.across():
        there = np.einsum("ij,ij->i", normals, np.cross(omega, arm))
        columns.append(there - np.einsum("ij,ij->i", turned_normals, np.cross(omega, back)))
    columns.extend((normals - turned_normals) @ shift for shift in axis.across())
    return np.column_stack(columns)
