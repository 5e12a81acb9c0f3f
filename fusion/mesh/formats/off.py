"""OFF files: the lines are counted and looked at, and trimesh reads them."""

import re

from fusion.files.reading import decoded
from fusion.mesh.formats.rows import filled, joined, table, told

START = re.compile(r"\s*(C|N|CN)?OFF\b", re.IGNORECASE)  # colours and normals of vertices are not read
FACE = re.compile(r"\s*([0-9]{1,9})((?:\s+[0-9]{1,9})*)(?:\s.*)?")  # colours may follow


def checked_off(data: bytes) -> bytes:
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
    if vertices and table(body[1 : 1 + vertices]).shape[1] < 3:
        raise ValueError(told(*body[1], "3 numbers"))
    for number, line in body[1 + vertices :]:
        face = FACE.fullmatch(line)
        if face is None or not 3 <= int(face[1]) <= len(face[2].split()):
            raise ValueError(told(number, line, "the number of corners, 3 or more, and as many indices"))
    return joined(body[1:], f"OFF\n{vertices} {faces} 0\n")
