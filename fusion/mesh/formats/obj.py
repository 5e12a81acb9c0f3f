"""OBJ files: vertices, perhaps with colours, and faces; materials and textures are not read."""

import re

import numpy as np
from numpy.typing import NDArray

from fusion.files.reading import decoded
from fusion.mesh.formats.polygons import triangles
from fusion.mesh.formats.rows import Lines, filled, table, told, whole
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept

COLUMNS = {
    3: None,
    4: None,
    6: 3,
    7: 4,
}  # numbers of a vertex (a weight may stand behind the place): where colour begins


def read_obj(data: bytes) -> Mesh:
    """The vertices that faces use, or all of them where there is no face; normals where each vertex has its own."""
    text = decoded(data)
    lines = filled(text.replace("\\\n", " ") if "\\\n" in text else text, "#")
    found: dict[str, Lines] = {"v": [], "vn": [], "f": []}
    before = []  # vertices above each face: negative indices count back from there
    for number, line in lines:
        key, _, rest = line.lstrip().replace("\t", " ").partition(" ")
        if key in found:
            found[key].append((number, rest))
            if key == "f":
                before.append(len(found["v"]))
    values = table(found["v"])
    if len(values) and values.shape[1] not in COLUMNS:
        raise ValueError(told(*found["v"][0], "3 numbers"))
    mesh = Mesh(values[:, :3].reshape(-1, 3), colors=_colors(values))
    if not found["f"]:
        return mesh
    polygons, same_normals = _polygons(found["f"], np.array(before), len(values))
    normals = table(found["vn"], 3) if same_normals and len(found["vn"]) == len(values) else None
    faces = triangles(polygons)
    used = np.zeros(len(values), bool)
    used[faces] = True
    whole_mesh = Mesh(
        mesh.vertices,
        faces.astype(np.int32),
        None if normals is None else normals.astype(np.float32),
        mesh.colors,
    )
    return vertices_kept(whole_mesh, used)


def _colors(values: NDArray[np.float64]) -> NDArray[np.uint8] | None:
    at = COLUMNS[values.shape[1]] if len(values) else None
    if at is None:
        return None
    colors = np.nan_to_num(values[:, at:])
    return np.rint(np.clip(colors if colors.max() > 1 else 255 * colors, 0, 255)).astype(np.uint8)


def _polygons(lines: Lines, before: NDArray[np.int64], count: int) -> tuple[list[NDArray[np.int64]], bool]:
    """Corners from 0 in groups of equal length, and whether each corner names the normal with its vertex's number."""
    groups: dict[int, list[int]] = {}
    same_normals = "/" in lines[0][1]
    for place, (_, rest) in enumerate(lines):
        groups.setdefault(len(rest.split()), []).append(place)
    found = []
    for corners, places in groups.items():
        same = [lines[place] for place in places]
        if corners < 3:
            raise ValueError(told(same[0][0], "f " + same[0][1], "3 corners or more"))
        plain = _without(r"/\S*", same)  # the numbers of texture and normal behind a vertex's
        indices = _from_zero(whole(table(plain, corners), plain), before[places], count, same)
        same_normals = same_normals and _without(r"[^\s/]+/[^\s/]*/(?=\S)", same) == plain
        found.append(indices)
    return found, same_normals


def _without(pattern: str, lines: Lines) -> Lines:
    """The same lines without what a regular expression finds."""
    texts = re.sub(pattern, "", "\n".join(line for _, line in lines)).split("\n")
    return [(number, text) for (number, _), text in zip(lines, texts, strict=True)]


def _from_zero(indices: NDArray[np.int64], before: NDArray[np.int64], count: int, lines: Lines) -> NDArray[np.int64]:
    """Indices from 0 of those from 1, or back from the last vertex above."""
    made = np.where(indices > 0, indices - 1, before[:, None] + indices)
    wrong = ((indices == 0) | (made < 0) | (made >= count)).any(axis=1)
    if wrong.any():
        number, rest = lines[int(np.argmax(wrong))]
        raise ValueError(told(number, "f " + rest, f"indices from 1 to {count}"))
    return made
