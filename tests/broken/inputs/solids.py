"""Meshes and point clouds of every format."""

import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from broken import meshes
from broken.case import ACCEPTED, EITHER, REFUSED, Case
from broken.crossing import over_file
from broken.inputs.clouds import clouds, objs
from broken.inputs.glb import glbs
from broken.inputs.ply import Broken, plys
from broken.meshes import (
    GOOD,
    cube,
)
from broken.odd_files import NO_FILE, cuts, encodings

CONVERT = {"convert": ["convert", "FILE", "out.ply"]}
OTHERS = {
    "compare": ["compare", "FILE", "good.ply", "-o", "out", "--no-report"],
    "reference": ["compare", "good.ply", "FILE", "-o", "out", "--no-report"],
    "repeat": ["repeat", "good.ply", "FILE", "-o", "out", "--no-report"],
    "simulate": [
        "simulate",
        "turntable",
        "--set",
        "frames=2",
        "--set",
        "mesh=FILE",
        "--camera",
        "camera.json",
        "-o",
        "out",
    ],
    "to print": ["convert", "FILE", "out.ply", "--watertight", "--triangles", "400"],
    "to glb": ["convert", "FILE", "out.glb"],
}


def others() -> Iterator[Broken]:
    """OFF, STL, GLB."""
    good = meshes.off(cube())
    for name, told in {
        "10^9 faces": b"8 1000000000 0",
        "10^9 vertices": b"1000000000 12 0",
        "-1": b"-1 12 0",
        "a word": b"8 twelve 0",
        "two numbers": b"8 12",
        "8 vertices of 9": b"9 12 0",
    }.items():
        yield f"{name} cube.off", good.replace(b"8 12 0", told), EITHER if name == "two numbers" else REFUSED
    for name, row in {
        "index 8": b"3 0 1 8",
        "index -1": b"3 0 1 -1",
        "4 of 3": b"4 0 1 2",
        "10^9 corners": b"1000000000 0 1 2",
        "a word": b"3 0 1 x",
    }.items():
        yield f"{name} cube.off", good[: good.rindex(b"3 ")] + row + b"\n", REFUSED
    binary = meshes.stl_binary(cube())
    for name, count in {"10^9 triangles": 10**9, "more than there are": 13, "0": 0, "4 billion": 2**32 - 1}.items():
        yield f"{name} binary.stl", binary[:80] + struct.pack("<I", count) + binary[84:], REFUSED
    yield "nan binary.stl", binary[:96] + struct.pack("<f", np.nan) + binary[100:], EITHER
    text = meshes.stl_ascii(cube())
    yield "a word ascii.stl", text.replace(b"vertex 0.1", b"vertex left", 1), REFUSED
    yield "two corners ascii.stl", text.replace(b"vertex -0.1 -0.1 -0.1\n", b"", 1), REFUSED
    yield "no end ascii.stl", text[: len(text) // 2], REFUSED
    yield "solid alone ascii.stl", b"solid x\nendsolid x\n", REFUSED
    yield from glbs()


def any_format() -> Iterator[Broken]:
    """What can befall any file."""
    for name, write in GOOD.items():
        good = write(cube())
        yield f"good {name}", good, ACCEPTED
        yield f"empty {name}", b"", REFUSED
        yield f"zeros {name}", bytes(3000), REFUSED
        yield f"a JPEG {name}", b"\xff\xd8\xff\xe0" + bytes(range(256)) * 4, REFUSED
        sure = name not in ("points.xyz", "cube.obj")  # whose format has no end
        for at, content in cuts(good, 5):
            yield f"cut at {at} {name}", content, REFUSED if sure else EITHER
        for other, write_other in GOOD.items():
            if other.split(".")[-1] != name.split(".")[-1] and other in (
                "ascii.ply",
                "cube.obj",
                "binary.stl",
                "cube.glb",
            ):
                yield f"holds {other} {name}", write_other(cube()), EITHER
        if name in ("ascii.ply", "ascii.pcd", "points.xyz", "cube.obj", "cube.off", "ascii.stl"):
            for kind, content in encodings(good):
                yield f"{kind} {name}", content, ACCEPTED if kind in ("BOM", "CRLF") else EITHER


def finite(folder: Path, printed: str) -> str:
    """A converted cube is the cube: a few decimetres, no number out of nowhere."""
    path = folder / "out.ply"
    raw = path.read_bytes() if path.is_file() else b""
    if not raw.startswith(b"ply") or b"end_header\n" not in raw:
        return "no PLY was written"
    numbers = _coordinates(raw)
    used = numbers[np.isfinite(numbers)]
    tiny = (used != 0) & (np.abs(used) < 1e-30)
    return "numbers that are in no input" if tiny.any() else ""


def _coordinates(raw: bytes) -> np.ndarray:
    head, body = raw.split(b"end_header\n", 1)
    types = {
        b"float": "<f4",
        b"float32": "<f4",
        b"double": "<f8",
        b"float64": "<f8",
        b"uchar": "u1",
        b"uint8": "u1",
        b"int": "<i4",
        b"uint": "<u4",
    }
    fields, count, vertex = [], 0, False
    for line in head.splitlines():
        words = line.split()
        if words[:1] == [b"element"]:
            vertex = words[1] == b"vertex"
            count = int(words[2]) if vertex else count
        elif words[:1] == [b"property"] and vertex:
            fields.append((words[2].decode(), types[words[1]]))
    if b"binary_little_endian" not in head:
        return np.zeros(0)
    table = np.frombuffer(body, dtype=fields, count=count)
    return np.concatenate([table[axis].astype(float) for axis in "xyz"])


def all_broken() -> list[Broken]:
    return [*plys(), *clouds(), *objs(), *others(), *any_format()]


QUICK = (
    "POINTS 3 and one line ascii.pcd",
    "4 of 12 faces ascii.ply",
    "1000000000 faces claimed little.ply",
    "f 0 1 2 cube.obj",
    "last v one number cube.obj",
    "good cube.glb",
)


def cases() -> Iterator[Case]:
    rest = list(OTHERS.items())
    for number, (name, content, expected) in enumerate(all_broken()):
        for case in over_file("mesh", name, content, CONVERT, expected=expected, out="out.ply", look=finite):
            yield case.as_quick() if name in QUICK else case
        command, words = rest[number % len(rest)]  # the others in turn: each reads by the same readers
        out = words[2] if command in ("to glb", "to print") else "out"
        good = (
            expected
            if command in ("to glb", "simulate") and expected is REFUSED
            else EITHER
            if expected is ACCEPTED or command != "to glb"
            else expected
        )
        yield from over_file(
            "mesh", name, content, {command: words}, expected=good if expected is not REFUSED else REFUSED, out=out
        )
    for name, put in NO_FILE.items():
        for ending in ("x.ply", "x.pcd", "x.obj", "x.stl", "x.glb", "x.off", "x.xyz"):
            for case in over_file("mesh is", f"{name} {ending}", put, CONVERT, expected=REFUSED, out="out.ply"):
                yield replace(
                    case, where=(*case.where, "out.ply")
                )  # a folder is taken for a recording, which becomes no mesh
