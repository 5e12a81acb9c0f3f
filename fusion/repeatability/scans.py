"""Scans to compare with each other: mesh files, or results of a scan."""

from dataclasses import dataclass
from pathlib import Path

from fusion.errors import MeshError
from fusion.mesh.files import read_mesh
from fusion.mesh.formats.conventions import from_file
from fusion.mesh.mesh import Mesh

MESH = "mesh.ply"  # in a result's folder


@dataclass(frozen=True)
class NamedMesh:
    """A scan's mesh, and what it is called."""

    name: str
    mesh: Mesh


def read_scans(paths: list[Path], notes: list[str] | None = None) -> list[NamedMesh]:
    """Mesh files and folders with a mesh.ply, as `fusion turntable` makes them, in metres: STL is millimetres.

    Raises:
        MeshError: a path that is neither, or a mesh without triangles.
    """
    found = []
    for path in paths:
        file = path / MESH if path.is_dir() else path
        if path.is_dir() and not file.is_file():
            raise MeshError("this is no scan", path, "a folder without mesh.ply", "a mesh, or a result of turntable")
        mesh = from_file(read_mesh(file, notes), file.suffix.lower())
        if not len(mesh.faces):
            raise MeshError("a scan without triangles", path, "a point cloud", "a mesh")
        name = path.name if path.is_dir() or path.name != MESH else path.parent.name
        found.append(NamedMesh(name or str(path), mesh))
    return found
