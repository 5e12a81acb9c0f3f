"""Formats that hold a coordinate in 32 bits: a mesh far from the origin is refused where they would bend it."""

from pathlib import Path

import numpy as np

from fusion.errors import MeshError
from fusion.mesh.mesh import Mesh

# all that are written with 32 bits; PLY takes 64 where it needs them
SINGLE = ".stl", ".glb", ".pcd", ".3mf", ".usdz"
OF_EDGE = 0.1  # of the median edge: by more, triangles are others and normals turn (guess)
OF_SIZE = 1e-3  # of the longest side of the box: 0.1 mm of 100 mm, about what a depth camera tells at best (guess)
BUT_FOR = 0.01  # of the vertices may move farther: a speck far out is no reason to refuse what else is there (guess)
EDGES = 200_000  # triangles that tell the median edge


def check_single(path: Path, mesh: Mesh) -> None:
    """Raises MeshError where 32 bits a coordinate would move vertices by more than a small share of the mesh."""
    ending = path.suffix.lower()
    if ending not in SINGLE or not len(mesh.vertices):
        return
    moved = np.linalg.norm(mesh.vertices - mesh.vertices.astype(np.float32), axis=1)
    size = float(np.ptp(mesh.vertices, axis=0).max())
    edge = _edge(mesh, size)
    far = float(np.quantile(moved, 1 - BUT_FOR))
    if far <= min(OF_EDGE * edge, OF_SIZE * size) or not far > 0:
        return
    unit = "" if ending == ".stl" else " m"  # STL says none: its numbers are in whatever it was made in
    found = f"coordinates up to {np.abs(mesh.vertices).max():.3g}{unit}: rounding would move vertices by up to "
    found += f"{moved.max():.2g}{unit}, of {size:.3g}{unit} in all"
    found += f" and edges of {edge:.2g}{unit}" if len(mesh.faces) else ""
    raise MeshError(
        f"{ending[1:].upper()} holds coordinates in 32 bits, too few so far from the origin",
        path.name,
        found,
        f"at most {min(OF_EDGE * edge, OF_SIZE * size):.1g}{unit}",
        "write PLY or OBJ, which keep such coordinates, or move the mesh to the origin first",
    )


def _edge(mesh: Mesh, size: float) -> float:
    """The median length of edges that have one; of a cloud, about how far its points lie apart on a surface."""
    if not len(mesh.faces):
        return size / np.sqrt(len(mesh.vertices))
    faces = mesh.faces[:: 1 + len(mesh.faces) // EDGES]
    lengths = np.linalg.norm(mesh.vertices[faces] - mesh.vertices[np.roll(faces, 1, axis=1)], axis=2)
    return float(np.median(lengths[lengths > 0])) if (lengths > 0).any() else size
