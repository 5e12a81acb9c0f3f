"""The open bottom of a scan: what stood on the plate was not seen, and is flat."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.cleanup import border_loops
from fusion.mesh.holes import holes
from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
# [m] a border so near above z = 0 stood on the plate that a turntable scan has there (guess); absolute: what is cut off
# with a plate follows the camera's noise, not the object's size
PLATE = 0.010
STEEPEST = 1.0  # inwards or outwards for each step down: farther on than at 45 degrees a flank is not followed (guess)
FLANK = 9  # corners of a border whose normals together tell how its flank goes on
SAME = 1e-6  # [m] between the centre of a hole and that of its border
FEWEST = 8  # corners of a border that is a foot, and no crack


@dataclass(frozen=True)
class Base:
    """Points (n, 3) that close the bottom, with normals (n, 3), and its height [m]."""

    points: Array
    normals: Array
    height: float


def base_of(mesh: Mesh, spacing: float) -> Base | None:
    """Walls that go on down from the border of the open bottom, and a flat foot; None where the bottom is closed.

    Where the border runs above the plate, the flank over it goes on as it is inclined: below an overhang inwards. A
    hole that begins above all that may have stood on the plate is no foot.

    Args:
        mesh: with normals, z up; of a turntable scan the plate is at z = 0, and what lay nearest to it was cut away.
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
    begin = [float(np.percentile(mesh.vertices[loop, 2], 10)) for loop in loops]
    height = 0.0 if 0 <= min(begin) < PLATE else min(begin)
    loops = [loop for loop, low in zip(loops, begin, strict=True) if low < min(begin) + PLATE]
    points, normals = [], []
    for loop in loops:
        assert mesh.normals is not None
        border = mesh.vertices[loop]
        out = _outwards(border)
        slope = _slope(mesh.normals[loop].astype(float), out)
        wall, facing = _walls(border, out, slope, height, spacing)
        stands = border + out * (slope * np.maximum(border[:, 2] - height, 0))[:, None]
        points += [wall, _foot(stands, height, spacing)]
        normals += [facing, np.tile(-UP, (len(points[-1]), 1))]
    return Base(np.concatenate(points), np.concatenate(normals), height)


def _outwards(border: Array) -> Array:
    """(k, 3) level unit vectors away from the hole; the border runs with the faces, the hole to its right."""
    along = np.roll(border, -1, axis=0) - np.roll(border, 1, axis=0)
    out = np.cross(along, UP)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    return -out if _area(border) < 0 else out  # the loop runs clockwise seen from above


def _slope(normals: Array, out: Array) -> Array:
    """(k,) how far the flank above each corner goes outwards for each step down."""
    calm = np.sum([np.roll(normals, step, axis=0) for step in range(-(FLANK // 2), FLANK // 2 + 1)], axis=0)
    level = np.maximum(np.einsum("ij,ij->i", calm, out), 1e-12)
    return np.asarray(np.clip(calm[:, 2] / level, -STEEPEST, STEEPEST))


def _walls(border: Array, out: Array, slope: Array, height: float, spacing: float) -> tuple[Array, Array]:
    """Below each corner of a border down to a height, along the flank above it; with normals."""
    points, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    facing = out + slope[:, None] * UP
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    deepest = float(border[:, 2].max() - height)
    for drop in np.arange(spacing, deepest, spacing):
        below = border + drop * (slope[:, None] * out - UP)
        under = below[:, 2] > height + spacing / 2
        points.append(below[under])
        normals.append(facing[under])
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
