"""PLY files, text and binary: the header, and whether every row is there that it promises, and nothing else."""

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.limits import check_size
from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.rows import Lines, check_whole, filled, joined, table, told

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


def checked_ply(data: bytes) -> bytes:
    """The vertices, and of the faces the lists of their corners, all of one length where the file is binary."""
    data = unmarked(data)
    begin = START.match(data)
    end = begin and re.compile(re.escape(begin[1]) + rb"end_header[ \t]*" + re.escape(begin[1])).search(data, 0, MOST)
    if not begin or not end:
        raise ValueError(f"no PLY header: {data[:8]!r}" if not begin else "a PLY header without its end")
    lines = data[: end.start()].decode("utf-8", "replace").split(begin[1].decode())
    form, elements = _header(lines[1:])
    if form == "ascii":
        vertices, faces, count = _text(elements, filled(decoded(data[end.end() :]), above=len(lines) + 1))
    else:
        vertices, faces, count = _binary(elements, ORDERS[form], data, end.end())
    vertex = elements["vertex"]
    head = ["ply", f"format {form} 1.0", f"element vertex {vertex.count}"]
    head += [f"property {kind} {name}" for name, (kind, _) in vertex.properties.items()]
    head += [f"element face {count}", "property list int int64 vertex_indices"] * bool(count) + ["end_header", ""]
    return "\n".join(head).encode() + vertices + faces


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


def _text(elements: dict[str, PlyElement], lines: Lines) -> tuple[bytes, bytes, int]:
    """Rows of the vertices, rows of the faces, and how many these are."""
    vertices: Lines = []
    faces: Lines = []
    for element in elements.values():
        rows, lines = lines[: element.count], lines[element.count :]
        if len(rows) < element.count:
            raise ValueError(f"{len(rows)} of {element.count} lines of element {element.name[:40]}")
        if element.name == "vertex":
            vertices, values = rows, table(rows, len(element.properties))
            for column, (kind, _) in zip(values.T, element.properties.values(), strict=True):
                if kind in LENGTHS:
                    check_whole(column, rows, TYPES[kind])
        elif element.name == "face" and rows:
            index = list(element.properties).index(element.index())
            faces = [(number, _corners(element, index, number, line)) for number, line in rows]
    if lines:
        raise ValueError(told(*lines[0], "the end of the file"))
    return joined(vertices), joined(faces), len(faces)


def _corners(element: PlyElement, index: int, number: int, line: str) -> str:
    """`3 0 1 2` of a face's line, which may hold more."""
    words, at, found = line.split(), 0, [""]
    for place, (_, length) in enumerate(element.properties.values()):
        there = words[at] if at < len(words) else ""
        many = 1 if not length else 1 + int(there) if INDEX.fullmatch(there) else len(line)
        found = words[at : at + many] if place == index else found
        at += many
    if at != len(words):
        raise ValueError(told(number, line, f"{at} numbers"))
    row = " ".join(found)
    if not INDICES.fullmatch(row):
        raise ValueError(told(number, line, "whole numbers"))
    if len(found) <= 3:
        raise ValueError(f"a face of {len(found) - 1} corners in line {number}")
    return row


def _binary(elements: dict[str, PlyElement], order: str, data: bytes, at: int) -> tuple[bytes, bytes, int]:
    """Rows of the vertices, rows of triangles, and how many these are."""
    from trimesh.geometry import triangulate_quads

    vertices, faces = b"", [np.zeros((0, 3), np.int64)]
    for element in elements.values():
        runs = _runs(element, order, data, at)
        end = at + sum(run.nbytes for run in runs)
        if element.name == "vertex":
            vertices = data[at:end]
        elif element.name == "face" and runs:
            polygons = [run[element.index()] for run in runs]
            few = min(one.shape[1] for one in polygons)
            if few < 3:
                raise ValueError(f"a face of {few} corners")
            check_size(24 * sum(one.size for one in polygons), "the faces of a PLY file", MeshError)
            faces += [triangulate_quads(one) for one in polygons]
        at = end
    if data[at:].strip(PADDING):
        raise ValueError(f"{len(data) - at} bytes more than the header promises")
    triangles = np.concatenate(faces)
    rows = np.empty(len(triangles), [("length", f"{order}i4"), ("corners", f"{order}i8", 3)])
    rows["length"], rows["corners"] = 3, triangles
    return vertices, rows.tobytes(), len(rows)


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
