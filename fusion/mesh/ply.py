"""PLY files: read by trimesh, written as CloudCompare likes them."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

_FLOAT32_EXACT = 8.0  # [m] below this float32 is exact to half a micrometre


def read_ply(path: Path) -> Mesh:
    """Vertices, faces (polygons become triangles), normals, colours and every other number per vertex.

    CloudCompare's fields `scalar_<name>` come back as scalars under `<name>`.
    """
    from trimesh.exchange.ply import load_ply
    from trimesh.geometry import triangulate_quads

    with path.open("rb") as file:
        loaded = load_ply(file, fix_texture=False, skip_materials=True, prefer_color="vertex")
    vertex = _columns(loaded["metadata"]["_ply_raw"]["vertex"])
    faces = loaded.get("faces")
    return Mesh(
        vertices=np.stack([vertex.pop(name) for name in "xyz"], axis=1).astype(np.float64),
        faces=np.zeros((0, 3), np.int64) if faces is None or not len(faces) else triangulate_quads(faces),
        normals=_taken(vertex, ("nx", "ny", "nz"), np.float32),
        colors=_colors(vertex),
        scalars={
            name.removeprefix("scalar_"): values.astype(np.float32)
            for name, values in vertex.items()
            if values.ndim == 1 and name not in ("alpha", "a")
        },
    )


def _columns(element: dict[str, Any]) -> dict[str, NDArray]:
    data = element["data"]  # a structured array, or columns by name where the file is text
    names = data.dtype.names if isinstance(data, np.ndarray) else list(data)
    return {name: np.asarray(data[name]).reshape(element["length"], -1).squeeze(axis=1) for name in names}


def _taken(columns: dict[str, NDArray], names: tuple[str, str, str], dtype: type) -> NDArray | None:
    if not all(name in columns for name in names):
        return None
    return np.stack([columns.pop(name) for name in names], axis=1).astype(dtype)


def _colors(columns: dict[str, NDArray]) -> NDArray[np.uint8] | None:
    for names in (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")):
        if all(name in columns for name in names):
            bytes_already = columns[names[0]].dtype.kind in "ui"
            values = np.stack([columns.pop(name) for name in names], axis=1)
            return np.clip(np.rint(values.astype(np.float64) * (1 if bytes_already else 255)), 0, 255).astype(np.uint8)
    return None


def write_ply(path: Path, mesh: Mesh) -> None:
    """Binary little-endian PLY; scalars as float properties `scalar_<name>`, which CloudCompare shows as fields."""
    near = np.abs(mesh.vertices).max(initial=0.0) < _FLOAT32_EXACT
    columns: list[tuple[str, str, NDArray]] = []
    columns += [(name, "<f4" if near else "<f8", mesh.vertices[:, i]) for i, name in enumerate("xyz")]
    if mesh.normals is not None:
        columns += [(name, "<f4", mesh.normals[:, i]) for i, name in enumerate(("nx", "ny", "nz"))]
    if mesh.colors is not None:
        columns += [(name, "u1", mesh.colors[:, i]) for i, name in enumerate(("red", "green", "blue"))]
    columns += [(f"scalar_{name.replace(' ', '_')}", "<f4", values) for name, values in mesh.scalars.items()]
    vertices = np.empty(len(mesh.vertices), [(name, dtype) for name, dtype, _ in columns])
    for name, _, values in columns:
        vertices[name] = values
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, mesh.faces
    with path.open("wb") as file:
        file.write(_header(vertices, len(mesh.faces)).encode("ascii", "replace"))
        vertices.tofile(file)
        faces.tofile(file)


def _header(vertices: NDArray, face_count: int) -> str:
    types = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    lines = ["ply", "format binary_little_endian 1.0", "comment fusion; unit: metre", f"element vertex {len(vertices)}"]
    lines += [f"property {types[np.dtype(dtype).str]} {name}" for name, dtype, *_ in vertices.dtype.descr]
    if face_count:
        lines += [f"element face {face_count}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""])
