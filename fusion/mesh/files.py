"""Mesh and point cloud files, read with every check once and written whole or not at all."""

import logging
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.mesh.clouds import read_pcd, read_xyz, write_pcd, write_xyz
from fusion.mesh.exchange import from_trimesh, to_trimesh
from fusion.mesh.mesh import Mesh
from fusion.mesh.ply import read_ply, write_ply
from fusion.mesh.vertices import joined, vertices_kept
from fusion.output import atomic_file

FORMATS = (".ply", ".obj", ".stl", ".glb", ".gltf", ".off", ".pcd", ".xyz")
_READERS = {".ply": read_ply, ".pcd": read_pcd, ".xyz": read_xyz}
_WRITERS = {".ply": write_ply, ".pcd": write_pcd, ".xyz": write_xyz}
_LARGEST = 1e9  # a coordinate beyond this is no length in metres or millimetres: a broken file
_log = logging.getLogger("fusion")


def read_mesh(path: Path | str, notes: list[str] | None = None) -> Mesh:
    """A mesh or point cloud (PLY, OBJ, STL, GLB, glTF, OFF, PCD, XYZ), in the file's own unit and axes.

    Args:
        path: the file; its ending tells the format. GLB and glTF are metres, Y up, and stay so.
        notes: what was left out is appended here; without a list it is logged as a warning.

    Returns:
        The mesh. Vertices that are not finite are left out with their faces. The triangles of OBJ and STL,
        which store corners apart, are joined where corners lie at exactly the same place.

    Raises:
        MeshError: no such file, unknown format, unreadable, empty, indices or coordinates out of bounds.

    >>> fusion.read_mesh("ball.ply")
    <Mesh: 642 vertices, 1,280 triangles, 100 x 100 x 100 mm; normals, colors, sigma>
    """
    path = Path(path)
    _check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # broken numbers are found below
            mesh = _READERS.get(path.suffix.lower(), _read_by_trimesh)(path)
    except PermissionError:
        raise
    except Exception as error:  # the readers raise all kinds of errors on broken files
        reason = (str(error).strip() or type(error).__name__).splitlines()[0][:150]
        do = "export the file again, as PLY if you can"
        raise MeshError("the mesh file cannot be read", path, reason, f"a complete {path.suffix} file", do) from error
    mesh, told = _checked(mesh, path)
    for note in told:
        if notes is None:
            _log.warning("%s: %s", path, note)
        else:
            notes.append(f"{path}: {note}")
    return mesh


def write_mesh(path: Path | str, mesh: Mesh) -> None:
    """Write PLY (all of the mesh), OBJ, STL, GLB, OFF (what they can hold), PCD or XYZ (its points).

    Raises:
        MeshError: an unknown ending, or a point cloud for a format of triangles.

    >>> fusion.write_mesh("ball.glb", fusion.read_mesh("ball.ply"))
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".gltf":
        raise MeshError("glTF is written as one file only", path, ending, "the ending .glb", "change the name")
    if ending not in FORMATS:
        raise MeshError("unknown mesh format", path, ending or "no ending", "one of " + " ".join(FORMATS))
    if not len(mesh.faces) and ending in (".stl", ".off"):
        raise MeshError("this format holds triangles only", path, "a point cloud", "PLY, PCD or XYZ", "change the name")
    with atomic_file(path) as partial:
        _WRITERS.get(ending, _write_by_trimesh)(partial, mesh)


def _check_file(path: Path) -> None:
    if not path.exists():
        raise MeshError("no such mesh file", path, do="check the path")
    if path.is_dir():
        raise MeshError("not a mesh file", path, "a folder", "a file such as mesh.ply")
    if path.suffix.lower() not in FORMATS:
        raise MeshError("unknown mesh format", path, path.suffix or "no ending", "one of " + " ".join(FORMATS))
    if path.stat().st_size == 0:
        raise MeshError("the mesh file is empty", path, "0 bytes", "a mesh or point cloud")


def _read_by_trimesh(path: Path) -> Mesh:
    import trimesh

    mesh = from_trimesh(trimesh.load(path, process=False, skip_materials=True))
    return mesh if not len(mesh.faces) or _misfits(mesh).any() else joined(mesh)


def _misfits(mesh: Mesh) -> NDArray[np.bool_]:
    return np.asarray(((mesh.faces < 0) | (mesh.faces >= len(mesh.vertices))).any(axis=1))


def _checked(mesh: Mesh, path: Path) -> tuple[Mesh, list[str]]:
    if not len(mesh.vertices):
        raise MeshError("the mesh is empty or damaged", path, "no vertices", "a mesh or point cloud")
    bad = int(_misfits(mesh).sum())
    if bad:
        found = f"{bad} faces that name other vertices"
        raise MeshError("faces do not fit the vertices", path, found, f"indices 0 to {len(mesh.vertices) - 1}")
    finite = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    notes = [] if finite.all() else [f"{int((~finite).sum())} vertices that are not finite were left out"]
    whole, mesh = mesh, vertices_kept(mesh, finite)
    if not len(mesh.vertices) or len(mesh.faces) < min(len(whole.faces), 1):
        raise MeshError("the mesh holds no numbers", path, "NaN or infinity everywhere", "finite vertices")
    largest = float(np.abs(mesh.vertices).max())
    if largest > _LARGEST:
        raise MeshError("coordinates out of bounds", path, f"{largest:.3g}", f"at most {_LARGEST:g}", "check the unit")
    degenerate = (mesh.faces == np.roll(mesh.faces, 1, axis=1)).any(axis=1)
    return replace(mesh, faces=mesh.faces[~degenerate].astype(np.int32)), notes


def _write_by_trimesh(path: Path, mesh: Mesh) -> None:
    to_trimesh(mesh).export(path, file_type=path.suffix.lower()[1:])
