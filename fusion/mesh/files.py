"""Mesh and point cloud files, read with every check once and written whole or not at all."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.errors import FusionError, MeshError
from fusion.files.limits import check_size
from fusion.files.output.publish import atomic_file
from fusion.files.reading import TEXT_TAKES, read_bytes
from fusion.mesh.formats.clouds import read_pcd, read_xyz, write_pcd, write_xyz
from fusion.mesh.formats.e57 import read_e57
from fusion.mesh.formats.exchange import by_trimesh, to_trimesh
from fusion.mesh.formats.gltf import NamedFiles, check_gltf
from fusion.mesh.formats.obj import checked_obj
from fusion.mesh.formats.off import checked_off
from fusion.mesh.formats.single import check_single
from fusion.mesh.formats.stl import checked_stl
from fusion.mesh.formats.threemf import read_3mf, threemf_library, write_3mf
from fusion.mesh.formats.usdz import usd_library, write_usdz
from fusion.mesh.mesh import Mesh
from fusion.mesh.ply import read_ply, write_ply
from fusion.mesh.vertices import joined, vertices_kept

FORMATS = (".ply", ".obj", ".stl", ".glb", ".gltf", ".off", ".pcd", ".xyz", ".asc", ".e57", ".3mf")
_READERS = {".ply": read_ply, ".pcd": read_pcd, ".xyz": read_xyz, ".asc": read_xyz}
_CHECKED = {".obj": checked_obj, ".stl": checked_stl, ".off": checked_off}  # before trimesh reads
_TEXT = (".obj", ".off", ".xyz", ".asc")  # the others may be
_TRIANGLE_SOUP = (".obj", ".stl", ".glb", ".gltf", ".off")  # which may store the corners of each triangle apart
_NEED_A_LIBRARY = {".e57": read_e57, ".3mf": read_3mf}
_WRITERS = {".ply": write_ply, ".pcd": write_pcd, ".xyz": write_xyz, ".asc": write_xyz}
_WRITERS |= {".3mf": write_3mf, ".usdz": write_usdz}
_NO_POINTS = (".stl", ".off", ".3mf", ".usdz")
_ONLY_READ = {".gltf": ".glb", ".e57": ".ply"}  # what to write instead
WRITTEN = (*(ending for ending in FORMATS if ending not in _ONLY_READ), ".usdz")
_WRITTEN_BY = {".3mf": threemf_library, ".usdz": usd_library}
LARGEST = 1e9  # a coordinate beyond this is no length in metres or millimetres: a broken file
TEXT_TOLD_BY = 1 << 16  # numbers that are not written as text hold a null byte before this one
_log = logging.getLogger("fusion")


def read_mesh(path: Path | str, notes: list[str] | None = None) -> Mesh:
    """A mesh or point cloud (PLY, OBJ, STL, GLB, glTF, OFF, PCD, XYZ, ASC, E57, 3MF), in the file's own unit and axes.

    Args:
        path: the file; its ending tells the format. GLB and glTF are metres, Y up, and stay so; E57 is metres;
            3MF says its unit, and comes in metres.
        notes: what was left out is appended here; without a list it is logged as a warning.

    Returns:
        The mesh. Vertices that are not finite are left out with their faces. The triangles of OBJ and STL,
        which store corners apart, are joined where corners lie at exactly the same place.

    Raises:
        MeshError: no such file, unknown format, unreadable, empty, indices or coordinates out of bounds; E57 or 3MF
            without its extra.

    >>> fusion.read_mesh("ball.ply")
    <Mesh: 642 vertices, 1,280 triangles, 100 x 100 x 100 mm; normals, colors, sigma>
    """
    path = Path(path)
    ending = _ending(path)
    data = read_bytes(path, MeshError, "the mesh file", takes=TEXT_TAKES if ending in _TEXT else 1)
    if not data:
        raise MeshError("the mesh file is empty", path, "0 bytes", "a mesh or point cloud")
    if b"\0" not in data[:TEXT_TOLD_BY]:
        check_size(TEXT_TAKES * len(data), path, MeshError, "the mesh file")
    try:
        mesh = _READERS[ending](data) if ending in _READERS else _by_library(data, ending, path)
    except FusionError:  # told already: too large, or outside its folder
        raise
    except Exception as error:  # ValueError; and trimesh, which reads glTF, raises all kinds on broken files
        reason = (str(error).strip() or type(error).__name__).splitlines()[0][:150]
        do = "export the file again, as PLY if you can"
        raise MeshError("the mesh file cannot be read", path, reason, f"a complete {ending} file", do) from error
    mesh, told = _checked(mesh, path)
    mesh = _without_lines(joined(mesh) if ending in _TRIANGLE_SOUP and len(mesh.faces) else mesh)
    for note in told:
        if notes is None:
            _log.warning("%s: %s", path, note)
        else:
            notes.append(f"{path}: {note}")
    return mesh


def _by_library(data: bytes, ending: str, path: Path) -> Mesh:
    if ending in _NEED_A_LIBRARY:
        return _NEED_A_LIBRARY[ending](data, path)
    if ending in _CHECKED:
        return by_trimesh(_CHECKED[ending](data), ending)
    check_gltf(data, path)
    return by_trimesh(data, ending, NamedFiles(path))


def write_mesh(path: Path | str, mesh: Mesh) -> None:
    """Write PLY (all of the mesh), OBJ, STL, GLB, OFF (what they can hold), PCD, XYZ or ASC (its points).

    3MF too (metres become its millimetres), with the extra `print`, and USDZ, with `usd`. Other numbers are written as
    they stand: `fusion convert` turns them to the y axis up for GLB and USDZ.

    Raises:
        MeshError: an unknown ending, a point cloud for a format of triangles, or a mesh so far from the origin that
            STL, GLB, PCD, 3MF or USDZ, which hold a coordinate in 32 bits, would bend it.

    >>> fusion.write_mesh("ball.glb", fusion.read_mesh("ball.ply"))
    """
    path = Path(path)
    check_written(path)
    ending = path.suffix.lower()
    if not len(mesh.faces) and ending in _NO_POINTS:
        raise MeshError("this format holds triangles only", path, "a point cloud", "PLY, PCD or XYZ", "change the name")
    check_single(path, mesh)
    with atomic_file(path) as partial:
        _WRITERS.get(ending, _write_by_trimesh)(partial, mesh)


def check_written(path: Path) -> None:
    """Raises MeshError where no mesh can be written under such a name."""
    ending = path.suffix.lower()
    if ending in _ONLY_READ:
        raise MeshError("this format is only read", path, ending, f"the ending {_ONLY_READ[ending]}", "change the name")
    if ending not in WRITTEN:
        raise MeshError("unknown mesh format", path, ending or "no ending", "one of " + " ".join(WRITTEN))
    if ending in _WRITTEN_BY:
        _WRITTEN_BY[ending](path)  # told before any work


def _ending(path: Path) -> str:
    """The file's ending; MeshError where no reader knows it, or where there is nothing to read."""
    if not _exists(path):
        raise MeshError("no such mesh file", path, do="check the path")
    if path.is_dir():
        raise MeshError("not a mesh file", path, "a folder", "a file such as mesh.ply")
    ending = path.suffix.lower()
    if ending in WRITTEN and ending not in FORMATS:
        do = "read the file that it was made of, or export GLB"
        raise MeshError("this format is only written", path, ending, "one of " + " ".join(FORMATS), do)
    if ending not in FORMATS:
        raise MeshError("unknown mesh format", path, path.suffix or "no ending", "one of " + " ".join(FORMATS))
    return ending


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # no name that a file can have
        return False


def _checked(mesh: Mesh, path: Path) -> tuple[Mesh, list[str]]:
    if not len(mesh.vertices):
        raise MeshError("the mesh is empty or damaged", path, "no vertices", "a mesh or point cloud")
    bad = int(((mesh.faces < 0) | (mesh.faces >= len(mesh.vertices))).any(axis=1).sum())
    if bad:
        found = f"{bad} faces that name other vertices"
        raise MeshError("faces do not fit the vertices", path, found, f"indices 0 to {len(mesh.vertices) - 1}")
    finite = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    notes = [] if finite.all() else [f"{int((~finite).sum())} vertices that are not finite were left out"]
    whole, mesh = mesh, vertices_kept(mesh, finite)
    if not len(mesh.vertices) or len(mesh.faces) < min(len(whole.faces), 1):
        raise MeshError("the mesh holds no numbers", path, "NaN or infinity everywhere", "finite vertices")
    largest = float(np.abs(mesh.vertices).max())
    if largest > LARGEST:
        raise MeshError("coordinates out of bounds", path, f"{largest:.3g}", f"at most {LARGEST:g}", "check the unit")
    return mesh, notes


def _without_lines(mesh: Mesh) -> Mesh:
    """Triangles that name a vertex twice are left out; joined corners may make such."""
    degenerate = (mesh.faces == np.roll(mesh.faces, 1, axis=1)).any(axis=1)
    return replace(mesh, faces=mesh.faces[~degenerate].astype(np.int32))


def _write_by_trimesh(path: Path, mesh: Mesh) -> None:
    to_trimesh(mesh).export(path, file_type=path.suffix.lower()[1:])
