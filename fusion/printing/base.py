"""The open bottom of a scan: what stood on the plate was not seen, and is flat."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.cleanup import border_loops
from fusion.mesh.holes import holes
from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
PLATE = 0.010  # [m] a border so near above z = 0 stood on the plate that a turntable scan has there (guess)
SAME = 1e-6  # [m] between the centre of a hole and that of its border
FEWEST = 8  # corners of a border that is a foot, and no crack


@dataclass(frozen=True)
class Base:
    """Points (n, 3) that close the bottom, with normals (n, 3), and its height [m]."""

    points: Array
    normals: Array
    height: float


def base_of(mesh: Mesh, spacing: float) -> Base | None:
    """Walls straight down from the border of the open bottom, and a flat foot; None where the bottom is closed.

    Args:
        mesh: z up; of a turntable scan the plate is at z = 0, and what lay nearest to it was cut away.
        spacing: between the points [m].
    """
    below = np.array([hole.centre for hole in holes(mesh, UP) if hole.where == "bottom"]).reshape(-1, 3)
    if not len(below):
        return None

    def is_below(loop: NDArray[np.int64]) -> bool:
        away = np.linalg.norm(below - mesh.vertices[loop].mean(axis=0), axis=1)
        return bool(away.min() < SAME and len(loop) >= FEWEST)

    loops = [loop for loop in border_loops(mesh) if is_below(loop)]
    if not loops:
        return None
    lowest = float(min(np.percentile(mesh.vertices[loop, 2], 10) for loop in loops))
    height = 0.0 if 0 <= lowest < PLATE else lowest
    points, normals = [], []
    for loop in loops:
        border = mesh.vertices[loop]
        wall, facing = _walls(border, height, spacing)
        points += [wall, _foot(border, height, spacing)]
        normals += [facing, np.tile(-UP, (len(points[-1]), 1))]
    return Base(np.concatenate(points), np.concatenate(normals), height)


def _walls(border: Array, height: float, spacing: float) -> tuple[Array, Array]:
    """Below each corner of a border down to a height; the border runs with the faces, the hole to its right."""
    along = np.roll(border, -1, axis=0) - np.roll(border, 1, axis=0)
    out = np.cross(along, UP)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    if _area(border) < 0:  # the loop runs clockwise seen from above
        out = -out
    points, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    deepest = float(border[:, 2].max() - height)
    for drop in np.arange(spacing, deepest, spacing):
        below = border - [0, 0, drop]
        under = below[:, 2] > height + spacing / 2
        points.append(below[under])
        normals.append(out[under])
    return np.concatenate(points), np.concatenate(normals)


def _foot(border: Array, height: float, spacing: float) -> Array:
    """Points of a grid within a border, at a height."""
    from matplotlib.path import Path as Outline

    low, high = border[:, :2].min(axis=0), border[:, :2].max(axis=0)
    x, y = (np.arange(a + spacing / 2, b, spacing) for a, b in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = grid[Outline(border[:, :2]).contains_points(grid)] if len(grid) else grid
    return np.column_stack([inside, np.full(len(inside), height)])


def _area(border: Array) -> float:
    x, y = border[:, 0], border[:, 1]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
