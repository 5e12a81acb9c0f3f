"""PLY files, text and binary: the header, and whether every row is there that it promises, and nothing else."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.limits import check_size
from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.rows import Lines, check_whole, filled, table, told

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float16": "f2", "float32": "f4", "float64": "f8",
}  # fmt: skip
LENGTHS = {name for name, kind in TYPES.items() if kind[0] != "f"}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
PROPERTY = re.compile(rf"(?:list ({'|'.join(LENGTHS)}) )?({'|'.join(TYPES)}) (\S+)")
START = re.compile(rb"ply[ \t]*(\r\n|\n|\r)", re.IGNORECASE)
INDEX, INDICES = re.compile("[0-9]{1,9}"), re.compile("[0-9]{1,9}( [0-9]{1,9})*")
MOST = 1_000_000  # bytes of a header
PADDING = b" \t\r\n\0"  # what may follow the last element
FEW = 64  # rows that are looked at together where lists differ in length


@dataclass(frozen=True)
class PlyElement:
    """`count` rows of properties, by name: (type, "" or the type of a list's length)."""

    name: str
    count: int
    properties: dict[str, tuple[str, str]] = field(default_factory=dict)

    def index(self) -> str:
        """The list that holds the corners of faces, told by its name, else the only one."""
        lists = [name for name, (kind, length) in self.properties.items() if length and kind in LENGTHS]
        named = [name for name in lists if name in ("vertex_indices", "vertex_index")] or lists
        if len(named) != 1:
            raise ValueError("faces without a list of whole numbers vertex_indices")
        return named[0]


def ply_content(data: bytes) -> tuple[dict[str, NDArray], NDArray]:
    """Columns (n,) of the vertices by name, and triangles (m, 3): polygons are cut. ValueError says what is wrong."""
    data = unmarked(data)
    begin = START.match(data)
    end = begin and re.compile(re.escape(begin[1]) + rb"end_header[ \t]*" + re.escape(begin[1])).search(data, 0, MOST)
    if not begin or not end:
        raise ValueError(f"no PLY header: {data[:8]!r}" if not begin else "a PLY header without its end")
    lines = data[: end.start()].decode("utf-8", "replace").split(begin[1].decode())
    form, elements = _header(lines[1:])
    if form == "ascii":
        return _text(elements, filled(decoded(data[end.end() :]), above=len(lines) + 1))
    return _binary(elements, ORDERS[form], data, end.end())


def _header(lines: list[str]) -> tuple[str, dict[str, PlyElement]]:
    """How the body is written, and its elements in their order."""
    form, elements, last = "", {}, PlyElement("", 0)
    for number, line in enumerate(lines, start=2):
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", kind, _] if kind in ORDERS and not form:
                form = kind
            case ["element", name, count] if re.fullmatch("[0-9]{1,15}", count) and name not in elements:
                last = elements[name] = PlyElement(name, int(count))
            case ["property", *words] if elements and (one := PROPERTY.fullmatch(" ".join(words))):
                if one[3] in last.properties:
                    raise ValueError(f"line {number} of the header: {one[3][:40]!r} twice")
                last.properties[one[3]] = (one[2], one[1] or "")
            case _:
                raise ValueError(f"line {number} of the header: {line[:40]!r}")
    vertex = elements.get("vertex", last)
    if not form or (elements.get("tristrips", vertex) is not vertex and elements["tristrips"].count):
        raise ValueError("triangle strips, which are not read" if form else "a header without format")
    if not vertex.count or not all(one.properties for one in elements.values()):
        raise ValueError("no vertices, or an element without a property")
    if not {"x", "y", "z"} <= set(vertex.properties) or any(length for _, length in vertex.properties.values()):
        raise ValueError("vertices without x, y and z, or with lists, which are not read")
    return form, elements


def _text(elements: dict[str, PlyElement], lines: Lines) -> tuple[dict[str, NDArray], NDArray]:
    columns: dict[str, NDArray] = {}
    faces: list[list[int]] = []
    for element in elements.values():
        rows, lines = lines[: element.count], lines[element.count :]
        if len(rows) < element.count:
            raise ValueError(f"{len(rows)} of {element.count} lines of element {element.name[:40]}")
        if element.name == "vertex":
            values = table(rows, len(element.properties))
            for column, (name, (kind, _)) in zip(values.T, element.properties.items(), strict=True):
                if kind in LENGTHS:
                    check_whole(column, rows, TYPES[kind])
                columns[name] = column.astype(TYPES[kind])
        elif element.name == "face" and rows:
            index = list(element.properties).index(element.index())
            faces = [_corners(element, index, number, line) for number, line in rows]
    if lines:
        raise ValueError(told(*lines[0], "the end of the file"))
    return columns, _triangles([np.array(faces) if {len(one) for one in faces} == {3} else faces] if faces else [])


def _corners(element: PlyElement, index: int, number: int, line: str) -> list[int]:
    """The corners of a face, of its line, which may hold more."""
    words, at, found = line.split(), 0, [""]
    for place, (_, length) in enumerate(element.properties.values()):
        there = words[at] if at < len(words) else ""
        many = 1 if not length else 1 + int(there) if INDEX.fullmatch(there) else len(line)
        found = words[at : at + many] if place == index else found
        at += many
    if at != len(words):
        raise ValueError(told(number, line, f"{at} numbers"))
    if not INDICES.fullmatch(" ".join(found)):
        raise ValueError(told(number, line, "whole numbers"))
    if len(found) <= 3:
        raise ValueError(f"a face of {len(found) - 1} corners in line {number}")
    return [int(word) for word in found[1:]]


def _binary(elements: dict[str, PlyElement], order: str, data: bytes, at: int) -> tuple[dict[str, NDArray], NDArray]:
    columns: dict[str, NDArray] = {}
    polygons: list[NDArray] = []
    for element in elements.values():
        runs = _runs(element, order, data, at)
        if element.name == "vertex":
            columns = {name: runs[0][name] for name in element.properties}
        elif element.name == "face" and runs:
            polygons = [run[element.index()] for run in runs]
            few = min(one.shape[1] for one in polygons)
            if few < 3:
                raise ValueError(f"a face of {few} corners")
            check_size(24 * sum(one.size for one in polygons), "the faces of a PLY file", MeshError)
        at += sum(run.nbytes for run in runs)
    if data[at:].strip(PADDING):
        raise ValueError(f"{len(data) - at} bytes more than the header promises")
    return columns, _triangles(polygons)


def _triangles(polygons: Sequence[NDArray | list[list[int]]]) -> NDArray:
    """(m, 3) of groups of polygons, each group in its order but for those with more corners."""
    found = [np.zeros((0, 3), np.int64)]
    for some in polygons:
        if isinstance(some, np.ndarray) and some.shape[1] == 3:
            found.append(some.astype(np.int64))
        else:
            from trimesh.geometry import triangulate_quads  # takes a third of a second to import

            found.append(triangulate_quads(some))
    return np.concatenate(found)


def _runs(element: PlyElement, order: str, data: bytes, at: int) -> list[NDArray]:
    """All rows in runs whose lists are of equal length, most often one; ValueError where the file is too short."""
    runs: list[NDArray] = []
    left = most = element.count
    while left:
        try:
            kind = _row_type(element, order, data, at)
            rows = np.frombuffer(data, kind, min(left, most, max(1, (len(data) - at) // kind.itemsize)), at)
        except ValueError:  # it does not fit into the file
            raise ValueError(f"{element.count - left} of {element.count} of element {element.name[:40]}") from None
        other = np.zeros(len(rows), bool)
        for name in kind.names or ():
            other |= rows[name] != rows[name][0] if name.startswith("length of ") else False
        runs.append(rows[: int(np.argmax(other)) if other.any() else None])
        left, at, most = left - len(runs[-1]), at + runs[-1].nbytes, max(FEW, 8 * len(runs[-1]))
    return runs


def _row_type(element: PlyElement, order: str, data: bytes, at: int) -> np.dtype:
    """numpy's type of the row that begins here; ValueError where that is beyond the file."""
    fields: list[tuple] = []
    for name, (kind, length) in element.properties.items():
        shape: tuple[int, ...] = ()
        if length:
            begin = at + np.dtype(fields).itemsize
            fields.append((f"length of {name}", order + TYPES[length]))
            shape = (int(np.frombuffer(data, order + TYPES[length], 1, begin)[0]),)
        fields.append((name, order + TYPES[kind], shape))
    return np.dtype(fields)
