"""PLY files, text and binary: all that the header promises, or an error."""

import numpy as np
from numpy.typing import NDArray

from fusion.files.reading import unmarked
from fusion.mesh.formats.ply_binary import read_binary_body
from fusion.mesh.formats.ply_header import read_header
from fusion.mesh.formats.ply_text import read_text_body
from fusion.mesh.formats.polygons import triangles
from fusion.mesh.mesh import Mesh


def read_ply(data: bytes) -> Mesh:
    """Vertices, faces (polygons become triangles), normals, colours and every other number per vertex.

    CloudCompare's fields `scalar_<name>` come back as scalars under `<name>`.
    """
    data = unmarked(data)
    header = read_header(data)
    content = read_binary_body(header, data) if header.order else read_text_body(header, data)
    vertex = content.vertex
    if not {"x", "y", "z"} <= set(vertex):
        raise ValueError("vertices without x, y and z")
    with np.errstate(over="ignore"):
        return Mesh(
            vertices=np.stack([vertex.pop(name) for name in "xyz"], axis=1).astype(np.float64),
            faces=triangles(content.faces),  # type: ignore[arg-type]  # their range is checked behind this
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
