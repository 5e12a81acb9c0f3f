"""PLY files, written as CloudCompare likes them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.formats.ply import ply_content
from fusion.mesh.mesh import Mesh

_FLOAT32_EXACT = 8.0  # [m] below this float32 is exact to half a micrometre


def read_ply(data: bytes) -> Mesh:
    """Vertices, faces (polygons become triangles), normals, colours and every other number per vertex.

    CloudCompare's fields `scalar_<name>` come back as scalars under `<name>`.
    """
    with np.errstate(all="ignore"):  # numbers out of bounds are found where the mesh is checked
        return _mesh(*ply_content(data))


def _mesh(vertex: dict[str, NDArray], faces: NDArray) -> Mesh:
    return Mesh(
        vertices=np.stack([vertex.pop(name) for name in "xyz"], axis=1).astype(np.float64),
        faces=faces,
        normals=_taken(vertex, ("nx", "ny", "nz"), np.float32),
        colors=_colors(vertex),
        scalars={
            name.removeprefix("scalar_"): values.astype(np.float32)
            for name, values in vertex.items()
            if name not in ("alpha", "a")
        },
    )


def _taken(columns: dict[str, NDArray], names: tuple[str, str, str], dtype: type) -> NDArray | None:
    if not all(name in columns for name in names):
        return None
    return np.stack([columns.pop(name) for name in names], axis=1).astype(dtype)


def _colors(columns: dict[str, NDArray]) -> NDArray[np.uint8] | None:
    for names in (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")):
        if all(name in columns for name in names):
            bytes_already = columns[names[0]].dtype.kind in "ui"
            values = np.stack([columns.pop(name) for name in names], axis=1)
            values = np.nan_to_num(values.astype(np.float64) * (1 if bytes_already else 255))
            return np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return None


def write_ply(path: Path, mesh: Mesh) -> None:
    """Binary little-endian PLY; scalars as float properties `scalar_<name>`, which CloudCompare shows as fields."""
    vertices = vertex_rows(mesh, exact_in_float32(mesh.vertices))
    with path.open("wb") as file:
        file.write(header(vertices.dtype, len(vertices), len(mesh.faces), mesh.notes))
        file.write(vertices.tobytes())  # not tofile: it does not tell why it could not write
        file.write(face_rows(mesh.faces).tobytes())


def exact_in_float32(coordinates: NDArray[np.float64]) -> bool:
    """Whether such coordinates [m] may be written as float32."""
    return bool(np.abs(coordinates).max(initial=0.0) < _FLOAT32_EXACT)


def vertex_rows(mesh: Mesh, single: bool) -> NDArray:
    """Vertices as they stand in a PLY file, with coordinates as float32 or float64."""
    columns: list[tuple[str, str, NDArray]] = []
    columns += [(name, "<f4" if single else "<f8", mesh.vertices[:, i]) for i, name in enumerate("xyz")]
    if mesh.normals is not None:
        columns += [(name, "<f4", mesh.normals[:, i]) for i, name in enumerate(("nx", "ny", "nz"))]
    if mesh.colors is not None:
        columns += [(name, "u1", mesh.colors[:, i]) for i, name in enumerate(("red", "green", "blue"))]
    columns += [(f"scalar_{name.replace(' ', '_')}", "<f4", values) for name, values in mesh.scalars.items()]
    vertices = np.empty(len(mesh.vertices), [(name, dtype) for name, dtype, _ in columns])
    for name, _, values in columns:
        vertices[name] = values
    return vertices


def face_rows(faces: NDArray[np.int32]) -> NDArray:
    """Triangles (m, 3) as they stand in a PLY file."""
    rows = np.empty(len(faces), [("count", "u1"), ("indices", "<i4", 3)])
    rows["count"], rows["indices"] = 3, faces
    return rows


def header(kind: np.dtype, vertices: int, faces: int, notes: Sequence[str] = ()) -> bytes:
    """What a PLY file begins with: so many vertices of such rows, so many triangles; notes [a line each]."""
    types = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    lines = ["ply", "format binary_little_endian 1.0", "comment fusion; unit: metre"]
    lines += [*(f"comment {note}" for note in notes), f"element vertex {vertices}"]
    lines += [f"property {types[np.dtype(dtype).str]} {name}" for name, dtype, *_ in kind.descr]
    if faces:
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""]).encode("ascii", "replace")
