"""Vertices and triangles of a PLY file, and the same file with its vertices elsewhere."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
TYPES |= {"double": "f8", "int8": "i1", "uint8": "u1", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"}


def read_ply(content: bytes) -> tuple[Array, NDArray[np.int64]]:
    """(n, 3) vertices and (m, 3) triangles; ASCII or little-endian, faces a plain list of three."""
    head, ascii_, counts, vertex = _header(content)
    body = content[len(head) :]
    if ascii_:
        lines = body.decode("ascii").splitlines()
        table = np.array([line.split() for line in lines[: counts[0]]], float)
        faces = np.array([line.split()[1:4] for line in lines[counts[0] : sum(counts)]], np.int64)
        return table[:, :3], faces
    table = np.frombuffer(body, vertex, counts[0])
    kind = np.dtype([("n", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(body, kind, counts[1], offset=table.nbytes)["corners"].astype(np.int64)
    return np.stack([table[axis] for axis in "xyz"], axis=-1).astype(float), faces


def changed_ply(content: bytes, change: Callable[[Array], Array]) -> bytes:
    """The same mesh with vertices `change(vertices)`; all else stays."""
    head, ascii_, counts, vertex = _header(content)
    moved = change(read_ply(content)[0])
    body = content[len(head) :]
    if ascii_:
        lines = body.decode("ascii").splitlines()
        for i, place in enumerate(moved):
            lines[i] = " ".join([*(f"{x:.8f}" for x in place), *lines[i].split()[3:]])
        return head + ("\n".join(lines) + "\n").encode("ascii")
    table = np.frombuffer(body, vertex, counts[0]).copy()
    for k, axis in enumerate("xyz"):
        table[axis] = moved[:, k]
    return head + table.tobytes() + body[table.nbytes :]


def _header(content: bytes) -> tuple[bytes, bool, list[int], "np.dtype[np.void]"]:
    """The header, whether text follows, numbers of vertices and faces, the layout of a vertex."""
    end = content.index(b"end_header\n") + len(b"end_header\n")
    words = [line.split() for line in content[:end].decode("ascii").splitlines()]
    counts = [int(line[2]) for line in words if line[0] == "element"]
    columns = [(line[2], "<" + TYPES[line[1]]) for line in words if line[0] == "property" and line[1] != "list"]
    return content[:end], ["format", "ascii", "1.0"] in words, counts, np.dtype(columns)
