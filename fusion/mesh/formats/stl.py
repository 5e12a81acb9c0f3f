"""STL files, binary and text: triangles whose corners are stored apart."""

import struct

import numpy as np

from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.rows import filled, table, told
from fusion.mesh.mesh import Mesh

HEAD = 84  # bytes before the first triangle
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def read_stl(data: bytes) -> Mesh:
    """The triangles; normals are told by the corners and are left out."""
    if len(data) >= HEAD:
        (count,) = struct.unpack("<I", data[HEAD - 4 : HEAD])
        if len(data) == HEAD + count * TRIANGLE.itemsize:
            return _mesh(np.frombuffer(data, TRIANGLE, count, HEAD)["corners"].reshape(-1, 3).astype(np.float64))
    text = unmarked(data).lstrip()
    if text[:5].lower() == b"solid" and b"\0" not in text[:HEAD]:
        return _mesh(_text(decoded(text)))
    if len(data) < HEAD:
        raise ValueError(f"{len(data)} bytes")
    raise ValueError(f"{count} triangles promised, {len(data) - HEAD} bytes for them, {TRIANGLE.itemsize} each")


def _text(text: str) -> np.ndarray:
    """(n, 3) corners, three for each triangle."""
    lines = filled(text)
    keys = [line.split(None, 1)[0].lower() for _, line in lines]
    if not keys or keys[0] != "solid" or keys[-1] != "endsolid":
        raise ValueError("a text that does not end with endsolid")
    inside = 0
    for key, (number, line) in zip(keys, lines, strict=True):
        if key in ("solid", "endsolid") and inside == 0:
            continue
        if key != FACET[inside]:
            raise ValueError(told(number, line, FACET[inside]))
        inside = (inside + 1) % len(FACET)
    corners = [
        (number, line.split(None, 1)[-1]) for key, (number, line) in zip(keys, lines, strict=True) if key == "vertex"
    ]
    return table(corners, 3)


def _mesh(corners: np.ndarray) -> Mesh:
    return Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
