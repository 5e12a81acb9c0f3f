"""PCD files of the Point Cloud Library: header and body are held against each other."""

import re
import struct

from fusion.errors import MeshError
from fusion.files.limits import check_size
from fusion.files.reading import decoded, unmarked
from fusion.mesh.formats.rows import check_whole, filled, joined, table, told

DATA = re.compile(rb"^DATA[ \t]+(ascii|binary|binary_compressed)[ \t]*\r?\n", re.MULTILINE | re.IGNORECASE)
FIELD = re.compile(r"\S+ (?:F [48]|[IU] [1248]) [1-9][0-9]{0,5}")
NORMAL = ("normal_x", "normal_y", "normal_z")
COLOR = ("rgb", "rgba")
MOST = 100_000  # bytes of a header
LINE, WIDEST = 1000, 100  # characters and fields of a row, of which Open3D takes no more
MANY = 2**31  # bytes and points, which it counts so far
WHOLE = re.compile("[-+]?(0|[1-9][0-9]*)")  # not 010, which is 8 to it, nor 1e2
POINT = 72  # bytes of place, normal and colour in Open3D
Fields = list[tuple[str, str, str, str]]  # name, type, size, count


def checked_pcd(data: bytes) -> tuple[bytes, int]:
    """All that was looked at, and how many points these are."""
    data = unmarked(data)
    begin = DATA.search(data, 0, MOST)
    if begin is None:
        raise ValueError("no PCD header")
    head, kind, body = decoded(data[: begin.start()]), begin[1].decode().lower(), data[begin.end() :]
    given = {line.split()[0]: line.split()[1:] for _, line in filled(head, "#")}
    fields, points = _fields(given, 8 if kind == "ascii" else 4), _points(given)
    row = sum(int(size) * int(count) for _, _, size, count in fields)
    if kind == "ascii":
        body = _rows(fields, points, decoded(body), head.count("\n") + 1)
    else:
        _check_binary(points * row, body, points, packed=kind != "binary")
    check_size(points * (row + POINT), "the points of a PCD file", MeshError)
    names = "\n".join(" ".join(words) for words in zip(("FIELDS", "TYPE", "SIZE", "COUNT"), *fields, strict=True))
    made = f"VERSION 0.7\n{names}\nWIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {kind}\n"
    return made.encode() + body, points


def _fields(given: dict[str, list[str]], largest: int) -> Fields:
    """Those that Open3D reads as they should be, under their names: of others it takes zeros, or writes anywhere."""
    names, kinds, sizes = (given.get(key, []) for key in ("FIELDS", "TYPE", "SIZE"))
    counts = given.get("COUNT", ["1"] * len(names))
    if not len(names) == len(kinds) == len(sizes) == len(counts) <= WIDEST:
        raise ValueError(f"a header whose FIELDS, TYPE, SIZE and COUNT do not fit, or more than {WIDEST} fields")
    fields = list(zip(names, kinds, sizes, counts, strict=True))
    wrong = next((" ".join(one) for one in fields if not FIELD.fullmatch(" ".join(one))), None)
    if wrong is not None:
        raise ValueError(f"a field, its type, size and count of {wrong[:40]!r}")
    single = [name for name, *_, count in fields if count == "1"]
    read = {name for name in (*"xyz", *NORMAL, *COLOR) if single.count(name) == names.count(name) == 1}
    if not set("xyz") <= read:
        raise ValueError("points without one x, y and z")
    read -= {name for name, _, size, _ in fields if name in COLOR and size != "4"}
    read -= set(NORMAL) if not set(NORMAL) <= read else set()
    large = [name for name, _, size, _ in fields if name in read and int(size) > largest]
    if large:
        raise ValueError(f"field {large[0]} of 8 bytes a number, which is read from DATA ascii only")
    return [(name if name in read else "_", kind, size, count) for name, kind, size, count in fields]


def _points(given: dict[str, list[str]]) -> int:
    points, width, height = (" ".join(given.get(key, [])) for key in ("POINTS", "WIDTH", "HEIGHT"))
    if not all(re.fullmatch("[0-9]{1,15}", one) for one in (points, width, height)):
        raise ValueError("a header without POINTS, WIDTH and HEIGHT")
    if int(points) != int(width) * int(height) or not 0 < int(points) < MANY:
        raise ValueError(f"POINTS {points}, but WIDTH {width} and HEIGHT {height}")
    return int(points)


def _rows(fields: Fields, points: int, text: str, above: int) -> bytes:
    lines = filled(text, above=above)
    if len(lines) < points:
        raise ValueError(f"{len(lines)} of {points} points")
    if len(lines) > points:
        raise ValueError(told(*lines[points], "the end of the file"))
    values, at = table(lines, sum(int(count) for *_, count in fields)), 0
    for name, kind, size, count in fields:
        if kind != "F" and name != "_":
            check_whole(values[:, at], lines, kind.lower() + size)
            for number, line in lines:
                if not WHOLE.fullmatch(line.split()[at]):
                    raise ValueError(told(number, line, f"{name} as a whole number"))
        at += int(count)
    longest = max(lines, key=lambda one: len(one[1]))
    if len(longest[1]) > LINE:
        raise ValueError(told(*longest, f"at most {LINE} characters"))
    return joined(lines)


def _check_binary(size: int, body: bytes, points: int, packed: bool) -> None:
    there, promised = len(body), size
    if packed:
        inside, promised = struct.unpack("<II", body[:8]) if there >= 8 else (0, -1)
        there = size if inside <= there - 8 else there
    if there < size or promised != size or (packed and size >= MANY):
        raise ValueError(f"{points} points need {size} bytes, {promised} promised, {len(body)} in the file")
    if not packed and body[size:].strip(b"\r\n\0 "):
        raise ValueError(f"{there - size} bytes more than the header promises")
