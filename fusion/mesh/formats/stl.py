"""STL files, binary and text: size and lines are looked at, and trimesh reads them."""

import struct

from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.rows import Lines, filled, joined, table, told

HEAD, TRIANGLE = 84, 50  # bytes before the first triangle, and of each
FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def checked_stl(data: bytes) -> bytes:
    """The triangles, whose corners are stored apart; normals are told by the corners and are left out."""
    count = struct.unpack("<I", data[HEAD - 4 : HEAD])[0] if len(data) >= HEAD else -1
    if len(data) == HEAD + count * TRIANGLE:
        return data
    text = unmarked(data).lstrip()
    if text[:5].lower() == b"solid" and b"\0" not in text[:HEAD]:
        return _facets(decoded(text))
    raise ValueError(f"{count} triangles promised, {len(data) - HEAD} bytes for them" if count >= 0 else "no STL")


def _facets(text: str) -> bytes:
    """All solids as one without a name, in which trimesh would look for vertices."""
    lines = filled(text.lower())
    kept: Lines = []
    corners: Lines = []
    keys = [line.split(None, 1)[0] for _, line in lines]
    if keys[-1] != "endsolid":
        raise ValueError("a text that does not end with endsolid")
    for key, (number, line) in zip(keys, lines, strict=True):
        inside = len(kept) % len(FACET)
        if key in ("solid", "endsolid") and inside == 0:
            continue
        if key != FACET[inside]:
            raise ValueError(told(number, line, FACET[inside]))
        kept.append((number, key if key != "vertex" else line))
        if key == "vertex":
            corners.append((number, line.split(None, 1)[-1]))
    table(corners, 3)
    return joined([*kept, (0, "endsolid")], "solid\n")
