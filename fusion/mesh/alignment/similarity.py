"""Rotation, scale and translation between two surfaces, and one weighted point-to-plane step that improves them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
SCALES = (0.8, 1.25)  # beyond this two surfaces do not differ by a scale error but by their unit or their shape
_DAMPING = 1e-9  # of the system's own size: holds still what the shape leaves free (a sphere's rotation)
_HELD = 1e-3  # of a unit force: more of it left over was put on something that is free
AS_WELL = 1.2  # an rms distance so many times larger is no clearly worse fit (guess)


@dataclass(frozen=True)
class Similarity:
    """A point p goes to `scale * rotation @ p + shift`."""

    rotation: Array  # (3, 3)
    shift: Array  # (3,) [m]
    scale: float = 1.0  # above 0

    def apply(self, points: Array) -> Array:
        """Points (n, 3), moved."""
        return self.scale * points @ self.rotation.T + self.shift

    def apply_inverse(self, points: Array) -> Array:
        """Points (n, 3), moved back."""
        return (points - self.shift) @ self.rotation / self.scale

    def inverse(self) -> "Similarity":
        """The way back."""
        return Similarity(self.rotation.T, -self.rotation.T @ self.shift / self.scale, 1 / self.scale)

    def matrix(self) -> Array:
        """(4, 4) of rotation and shift only, without the scale."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.rotation, self.shift
        return T


IDENTITY = Similarity(np.eye(3), np.zeros(3))


@dataclass(frozen=True)
class Matches:
    """Points as they stand now (n, 3) [m], what they belong to (n, 3), the normals there (n, 3), weights (n,)."""

    points: Array
    targets: Array
    normals: Array
    weights: Array

    @cached_property
    def rows(self) -> tuple[Array, Array, Array, float]:
        """Jacobian (n, 7) of rotation, shift and log-scale, all in lengths; residuals (n,) [m]; the centre; the size.

        Rotation and scale act about the points' centre and are measured by what they move at the shape's edge.
        """
        total = max(float(self.weights.sum()), 1e-300)
        centre = self.weights @ self.points / total
        arm = self.points - centre
        size = max(float(np.sqrt(self.weights @ (arm**2).sum(axis=1) / total)), 1e-300)
        arm = arm / size
        # of the targets: noise of the points stands in the residuals, too, and a scale of 0 would explain it all
        along = np.einsum("ij,ij->i", (self.targets - centre) / size, self.normals)[:, None]
        jacobian = np.hstack([np.cross(arm, self.normals), self.normals, along])
        return jacobian, np.einsum("ij,ij->i", self.normals, self.targets - self.points), centre, size


def step(now: Similarity, matches: Matches, scale: bool) -> tuple[Similarity, float]:
    """One Gauss-Newton step: the better similarity, and how far it moved the shape's edge [m]."""
    jacobian, residual, centre, size = matches.rows
    scale = scale and tells_scale(matches)  # of a plane noise alone speaks, and any smaller one has less of it
    jacobian = jacobian if scale else jacobian[:, :6]
    weighted = jacobian * matches.weights[:, None]
    change = solve(weighted.T @ jacobian, weighted.T @ residual)
    turn = Rotation.from_rotvec(change[:3] / size).as_matrix()
    grow = float(np.exp(np.clip(change[6] / size, -0.1, 0.1))) if scale else 1.0
    grow = float(np.clip(now.scale * grow, *SCALES)) / now.scale if scale else 1.0
    left, _, right = np.linalg.svd(turn @ now.rotation)
    rotation = left @ right  # stays a rotation over many steps
    shift = centre + grow * turn @ (now.shift - centre) + change[3:6]
    return Similarity(rotation, shift, now.scale * grow), float(np.linalg.norm(change))


def tells_scale(matches: Matches) -> bool:
    """Is a scale at the end of what is allowed clearly worse than the best one, all else following it?

    Of a plane, a cylinder cut off or a cone it is not: there the scale is free, or a shift makes up for it.
    """
    jacobian, residual, _, size = matches.rows
    weighted = jacobian * matches.weights[:, None]
    system, right = weighted.T @ jacobian, weighted.T @ residual
    column = np.eye(7)[6]
    moved = solve(system, column)  # per unit of force on the scale
    if moved[6] <= 0 or np.abs(system @ moved - column).max() > _HELD:
        return False
    left = float(matches.weights @ residual**2 - right @ solve(system, right))
    return float(np.log(SCALES[1]) * size) ** 2 / moved[6] > (AS_WELL**2 - 1) * max(left, 0.0)


def free_shifts(matches: Matches) -> list[Array]:
    """Unit vectors (3,), both ways, along which the normals of what lies on each other hold a shift least of all."""
    return [sign * axis for axis in held_axes(matches)[:2] for sign in (1.0, -1.0)]


def held_axes(matches: Matches) -> Array:
    """(3, 3) rows: axes of the normals of what lies on each other, the one that they hold a shift along least first."""
    normals = matches.normals[matches.weights > 0]
    return np.asarray(np.linalg.eigh(normals.T @ normals)[1].T)


def solve(system: Array, right: Array) -> Array:
    """The change that a normal system asks for; directions that it does not know stay still."""
    values, vectors = np.linalg.eigh(system)
    known = values > _DAMPING * max(float(values[-1]), 1e-300)
    return vectors[:, known] @ ((vectors[:, known].T @ right) / values[known])


def tukey(distances: Array, limit: float) -> Array:
    """Weights (n,): 1 at distance 0, 0 from `limit` on."""
    return np.square(np.maximum(1 - np.square(distances / max(limit, 1e-300)), 0))
