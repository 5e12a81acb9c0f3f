"""OFF files: counts, vertices, faces."""

import re

import numpy as np

from fusion.files.reading import decoded
from fusion.mesh.formats.polygons import triangles
from fusion.mesh.formats.rows import Lines, filled, table, told, whole
from fusion.mesh.mesh import Mesh

START = re.compile(r"\s*(C|N|CN)?OFF\b", re.IGNORECASE)  # colours and normals of vertices are not read


def read_off(data: bytes) -> Mesh:
    """Vertices and faces, polygons as triangles."""
    lines = filled(decoded(data), "#")
    begin = START.match(lines[0][1]) if lines else None
    if begin is None:
        raise ValueError("no OFF at the start")
    rest = lines[0][1][begin.end() :]
    body = [(lines[0][0], rest)] * bool(rest.strip()) + lines[1:]  # the counts may follow in the first line
    counts = body[0][1].split() if body else []
    if not 2 <= len(counts) <= 3 or not all(re.fullmatch("[0-9]{1,12}", word) for word in counts):
        raise ValueError(told(*body[0], "numbers of vertices and faces") if body else "no number of vertices")
    vertices, faces = int(counts[0]), int(counts[1])
    if len(body) != 1 + vertices + faces:
        raise ValueError(f"{len(body) - 1} lines for {vertices} vertices and {faces} faces")
    values = table(body[1 : 1 + vertices])
    if vertices and values.shape[1] < 3:
        raise ValueError(told(*body[1], "3 numbers"))
    return Mesh(values[:, :3].reshape(-1, 3), triangles(_polygons(body[1 + vertices :])))  # type: ignore[arg-type]


def _polygons(lines: Lines) -> list[np.ndarray]:
    groups: dict[int, Lines] = {}
    for number, line in lines:
        words = line.split()
        count = int(words[0]) if re.fullmatch("[0-9]{1,9}", words[0]) else -1
        if not 3 <= count < len(words):  # colours may follow
            raise ValueError(told(number, line, "the number of corners, 3 or more, and as many indices"))
        groups.setdefault(count, []).append((number, " ".join(words[1 : count + 1])))
    return [whole(table(same, count), same) for count, same in groups.items()]
