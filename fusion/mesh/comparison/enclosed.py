"""What of a reference nothing outside can see: faces within a CAD model's walls, or where its solids overlap."""

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.comparison.distances import MeshSurface

_ROUNDS = (12, 120)  # directions looked at; most points that are seen are seen in the first (guess)
_AT_ONCE = 2000  # points whose rays are in memory together


def enclosed(surface: MeshSurface, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the points (n, 3) [m] on a surface see the surface itself in every direction."""
    hidden = np.ones(len(points), bool)
    for count in _ROUNDS:
        ways, left = directions(count), np.flatnonzero(hidden)
        for rows in np.split(left, range(_AT_ONCE, len(left), _AT_ONCE)):
            shape = len(rows), count, 3
            hits = surface.hit(np.broadcast_to(points[rows, None], shape), np.broadcast_to(ways, shape))
            hidden[rows] = hits.all(axis=1)
    return hidden


def directions(count: int) -> NDArray[np.float64]:
    """Unit vectors (count, 3) all over the sphere: a spiral of the golden angle."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    flat = np.sqrt(1 - z**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
