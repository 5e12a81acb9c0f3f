"""How far the passes lie from each other on the merged surface."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.passes.poses.sides import REACHED, PassSide

Array = NDArray[np.float64]
APART, SEEN = "passes_apart", "passes"  # scalars: [m], and how many passes show a vertex


def between(mesh: Mesh, sides: Sequence[PassSide], T: Array) -> Mesh:
    """The mesh with how many passes show each vertex, and how far these lie from each other there (NaN: one alone)."""
    assert mesh.normals is not None
    heights = np.full((len(sides), len(mesh.vertices)), np.nan)
    for k, side in enumerate(sides):
        back = pose.inverse(T[k])
        points, normals = pose.transform(back, mesh.vertices), mesh.normals.astype(float) @ back[:3, :3].T
        index, known = side.nearest(points, side.noise + REACHED * side.spacing)
        off = np.einsum("ij,ij->i", side.points[index] - points, side.normals[index])
        same = np.einsum("ij,ij->i", normals, side.normals[index]) > 0.5
        heights[k] = np.where(known & same & (np.abs(off) <= side.noise), off, np.nan)
    seen = np.isfinite(heights).sum(axis=0)
    both = seen >= 2
    apart = np.full(len(mesh.vertices), np.nan, np.float32)
    apart[both] = np.nanmax(heights[:, both], axis=0) - np.nanmin(heights[:, both], axis=0)
    return replace(mesh, scalars=mesh.scalars | {SEEN: seen.astype(np.float32), APART: apart})
