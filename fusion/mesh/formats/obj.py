"""OBJ files: each vertex and face is looked at, and trimesh reads them; materials and textures are left out."""

import re

import numpy as np

from fusion.files.reading import decoded
from fusion.mesh.formats.rows import Lines, filled, joined, table, told

WIDTHS = {3: 3, 4: 4, 6: 3, 7: 4}  # numbers of a vertex (a weight may stand behind the place): where colour begins
LONGEST = 200_000  # characters of a face (guess): no program writes so many corners, and each takes much memory
CORNER = re.compile(r"([-+]?[0-9]{1,9})(?:/(?:-?[0-9]+)?(?:/(-?[0-9]+)?)?)?")  # of vertex, texture and normal


def checked_obj(data: bytes) -> bytes:
    """The vertices that faces use, or all of them where there is no face; normals where each vertex has one only."""
    text = decoded(data)
    vertices: Lines = []
    normals: Lines = []
    faces: list[tuple[int, str, int]] = []  # and how many vertices stand above
    for number, line in filled(text.replace("\\\n", " "), "#"):
        key, _, rest = line.lstrip().replace("\t", " ").partition(" ")
        if key == "v":
            vertices.append((number, rest))
        elif key == "vn":
            normals.append((number, rest))
        elif key == "f":
            faces.append((number, rest, len(vertices)))
    vertices = _vertices(vertices)
    table(normals, 3)
    kept = [(0, f"v {line}") for _, line in vertices] + [(0, f"vn {line}") for _, line in normals]
    kept += [(0, face) for one in faces for face in _triangles(*one, len(vertices), len(normals))]
    return joined(kept)


def _vertices(lines: Lines) -> Lines:
    """Places and colours from 0 to 1, as trimesh takes them."""
    values = table(lines)
    if lines and values.shape[1] not in WIDTHS:
        raise ValueError(told(*lines[0], "3 numbers"))
    colors = values[:, WIDTHS.get(values.shape[1], 3) :]
    if colors.size and np.nanmax(colors, initial=0) > 1:
        colors = colors / 255
    elif values.shape[1] in (3, 6):
        return lines
    return [(0, " ".join(map(str, row))) for row in np.hstack([values[:, :3], colors]).tolist()]


def _triangles(number: int, line: str, above: int, vertices: int, normals: int) -> list[str]:
    """A face's lines as trimesh reads them, counted from 1; it counts back from the end of the file, not from here."""
    if len(line) > LONGEST:
        raise ValueError(f"line {number}: a face of {len(line):,} characters; expected at most {LONGEST:,}")
    found = [CORNER.fullmatch(word) for word in line.split()]
    places = [int(one[1]) if one else 0 for one in found]
    places = [above + 1 + place if place < 0 else place for place in places]
    if len(places) < 3 or min(places) < 1 or max(places) > vertices:
        raise ValueError(told(number, f"f {line}", f"3 corners or more, from 1 to {vertices},"))
    words = [str(place) for place in places]
    if all(one and one[2] and 1 <= int(one[2][:9]) <= normals for one in found):
        words = [f"{word}//{one[2]}" for word, one in zip(words, found, strict=True) if one]
    return [f"f {words[0]} {words[i]} {words[i + 1]}" for i in range(1, len(words) - 1)]
