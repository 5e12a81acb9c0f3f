"""PLY files as CloudCompare likes them."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

_FLOAT32_EXACT = 8.0  # [m] below this float32 is exact to half a micrometre


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
        file.write(vertices.tobytes())  # not tofile: it does not tell why it could not write
        file.write(faces.tobytes())


def _header(vertices: NDArray, face_count: int) -> str:
    types = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    lines = ["ply", "format binary_little_endian 1.0", "comment fusion; unit: metre", f"element vertex {len(vertices)}"]
    lines += [f"property {types[np.dtype(dtype).str]} {name}" for name, dtype, *_ in vertices.dtype.descr]
    if face_count:
        lines += [f"element face {face_count}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""])
