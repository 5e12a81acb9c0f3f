"""PCD files of the Point Cloud Library: text, binary and compressed; all points that are promised, or an error."""

import re
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.limits import check_size
from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.lzf import unpacked
from fusion.mesh.formats.rows import filled, table, told
from fusion.mesh.mesh import Mesh

KINDS = {"F": {"4": "<f4", "8": "<f8"}, "I": {s: f"<i{s}" for s in "1248"}, "U": {s: f"<u{s}" for s in "1248"}}
DATA = re.compile(rb"^DATA[ \t]+(\w+)[ \t]*\r?\n", re.MULTILINE)
MOST = 100_000  # bytes of a header


@dataclass(frozen=True)
class Header:
    """Names, numpy's types and lengths of the fields, how many points, and where they begin [bytes, lines]."""

    fields: tuple[tuple[str, str, int], ...]
    points: int
    start: int
    lines: int

    @property
    def row(self) -> np.dtype:
        """Of one point; fields that share a name (padding is called `_`) are told apart by their place."""
        names = [name for name, *_ in self.fields]
        apart = [name if names.count(name) == 1 else f"{name} {place}" for place, name in enumerate(names)]
        return np.dtype([(name, kind, (n,)) for name, (_, kind, n) in zip(apart, self.fields, strict=True)])


def read_pcd(data: bytes) -> Mesh:
    """Points, normals and colours; a point that was not measured is NaN, as it stands in the file."""
    data = unmarked(data)
    begin = DATA.search(data, 0, MOST)
    if begin is None:
        raise ValueError("no PCD header")
    header = _header(decoded(data[: begin.start()]), begin.end())
    body, kind = data[begin.end() :], begin[1].decode().lower()
    if kind not in ("ascii", "binary", "binary_compressed"):
        raise ValueError(f"DATA {kind[:40]}")
    if kind == "ascii":
        rows = _text(header, decoded(body))
    elif kind == "binary":
        rows = _binary(header, body)
    else:
        rows = _compressed(header, body)
    if rows.dtype.names is None or not {"x", "y", "z"} <= set(rows.dtype.names):
        raise ValueError("points without x, y and z")
    return Mesh(_taken(rows, "xyz").astype(np.float64), normals=_normals(rows), colors=_colors(rows))


def _header(text: str, start: int) -> Header:
    given: dict[str, list[str]] = {}
    for number, line in filled(text, "#"):
        key, *words = line.split()
        if key in given:
            raise ValueError(told(number, line, "another entry"))
        given[key] = words
    names = given.get("FIELDS", [])
    types, sizes = given.get("TYPE", []), given.get("SIZE", [])
    counts = given.get("COUNT", ["1"] * len(names))
    if not names or not len(names) == len(types) == len(sizes) == len(counts) <= 1000:
        raise ValueError("a header whose FIELDS, TYPE, SIZE and COUNT do not fit")
    fields = []
    for name, kind, size, count in zip(names, types, sizes, counts, strict=True):
        if size not in KINDS.get(kind, {}) or not re.fullmatch("[1-9][0-9]{0,5}", count):
            raise ValueError(f"field {name[:40]} of type {kind[:9]}, size {size[:9]}, count {count[:9]}")
        fields.append((name, KINDS[kind][size], int(count)))
    points, width, height = (given.get(key, []) for key in ("POINTS", "WIDTH", "HEIGHT"))
    if not all(len(one) == 1 and re.fullmatch("[0-9]{1,15}", one[0]) for one in (points, width, height)):
        raise ValueError("a header without POINTS, WIDTH and HEIGHT")
    if int(points[0]) != int(width[0]) * int(height[0]):
        raise ValueError(f"POINTS {points[0]}, but WIDTH {width[0]} and HEIGHT {height[0]}")
    return Header(tuple(fields), int(points[0]), start, text.count("\n") + 1)


def _text(header: Header, text: str) -> NDArray:
    lines = [(number + header.lines, line) for number, line in filled(text)]
    if len(lines) != header.points:
        raise ValueError(
            f"{len(lines)} of {header.points} points"
            if len(lines) < header.points
            else told(*lines[header.points], "the end of the file")
        )
    values = table(lines, sum(n for *_, n in header.fields))
    rows, at = np.zeros(header.points, header.row), 0
    for name, (_, kind, n) in zip(header.row.names or (), header.fields, strict=True):
        part = values[:, at : at + n]
        if kind[1] != "f":
            limits = np.iinfo(kind)
            with np.errstate(invalid="ignore"):
                good = (part >= limits.min) & (part <= limits.max) & (part == np.rint(part))
            if not good.all():
                raise ValueError(told(*lines[int(np.argmin(good.all(axis=1)))], f"{name[:40]} of type {kind[1:]}"))
        with np.errstate(over="ignore"):
            rows[name] = part
        at += n
    return rows


def _binary(header: Header, body: bytes) -> NDArray:
    size = header.points * header.row.itemsize
    if len(body) < size:
        raise ValueError(f"{len(body) // header.row.itemsize} of {header.points} points")
    if body[size:].strip(b"\r\n\0 "):
        raise ValueError(f"{len(body) - size} bytes more than the header promises")
    return np.frombuffer(body, header.row, header.points)


def _compressed(header: Header, body: bytes) -> NDArray:
    """The fields stand one after the other, packed by LZF."""
    size = header.points * header.row.itemsize
    packed, whole = struct.unpack("<II", body[:8]) if len(body) >= 8 else (0, -1)
    if whole != size or packed > len(body) - 8:
        raise ValueError(
            f"{header.points} points need {size} bytes, {whole} promised, {len(body) - 8} packed ones there"
        )
    check_size(size, "the points of a PCD file", MeshError)
    plain = unpacked(body[8 : 8 + packed], size)
    rows, at = np.zeros(header.points, header.row), 0
    for name, (_, kind, n) in zip(header.row.names or (), header.fields, strict=True):
        rows[name] = np.frombuffer(plain, kind, header.points * n, at).reshape(-1, n)
        at += rows[name].nbytes
    return rows


def _taken(rows: NDArray, names: str | tuple[str, ...]) -> NDArray:
    for name in names:
        if rows[name].shape[1:] != (1,):
            raise ValueError(f"{name} of {rows[name].shape[1]} numbers a point")
    return np.concatenate([rows[name] for name in names], axis=1)


def _normals(rows: NDArray) -> NDArray[np.float32] | None:
    names = ("normal_x", "normal_y", "normal_z")
    with np.errstate(over="ignore"):
        return _taken(rows, names).astype(np.float32) if set(names) <= set(rows.dtype.names or ()) else None


def _colors(rows: NDArray) -> NDArray[np.uint8] | None:
    """Red, green and blue are packed in four bytes, which may be called a float."""
    name = next((name for name in ("rgb", "rgba") if name in (rows.dtype.names or ())), None)
    if name is None or rows[name].dtype.itemsize != 4 or rows[name].shape[1:] != (1,):
        return None
    packed = np.ascontiguousarray(rows[name]).view(np.uint32)
    return np.concatenate([packed >> shift & 255 for shift in (16, 8, 0)], axis=1).astype(np.uint8)
