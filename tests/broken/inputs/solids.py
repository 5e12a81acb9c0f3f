"""Meshes and point clouds of every format."""

import json
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from broken import meshes
from broken.case import ACCEPTED, EITHER, REFUSED, TOLD, Case, Expected
from broken.crossing import over_file
from broken.meshes import (
    GOOD,
    Shape,
    cube,
    glb_file,
    glb_json,
    pcd_ascii,
    pcd_binary,
    pcd_header,
    ply_ascii,
    ply_binary,
    ply_header,
)
from broken.odd_files import NO_FILE, cuts, encodings

CONVERT = {"convert": ["convert", "FILE", "out.ply"]}
OTHERS = {
    "compare": ["compare", "FILE", "good.ply", "-o", "out", "--no-report"],
    "reference": ["compare", "good.ply", "FILE", "-o", "out", "--no-report"],
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
    "to glb": ["convert", "FILE", "out.glb"],
}
Broken = tuple[str, bytes, Expected]  # name that ends with the file's, content, what is right


def plys() -> Iterator[Broken]:
    """PLY by its definition: a header that promises, and a body that keeps it or not."""
    box, text = cube(), ply_ascii(cube())
    lines = text.splitlines(keepends=True)
    yield "4 of 12 faces ascii.ply", b"".join(lines[:-8]), REFUSED
    yield "5 of 8 vertices ascii.ply", b"".join(lines[:-15]), REFUSED
    for count in ("1000000000", "99999999999999999999", "-1", "1.5", "many", "9" * 400, "4294967297"):
        yield (
            f"{_short(count)} faces claimed ascii.ply",
            text.replace(b"element face 12", f"element face {count}".encode()),
            REFUSED,
        )
        yield (
            f"{_short(count)} vertices claimed ascii.ply",
            text.replace(b"element vertex 8", f"element vertex {count}".encode()),
            REFUSED,
        )
        yield (
            f"{_short(count)} faces claimed little.ply",
            ply_binary(box).replace(b"element face 12", f"element face {count}".encode()),
            REFUSED,
        )
        yield (
            f"{_short(count)} vertices claimed little.ply",
            ply_binary(box).replace(b"element vertex 8", f"element vertex {count}".encode()),
            REFUSED,
        )
    for name, raw in {
        "nan": b"nan",
        "inf": b"inf",
        "a word": b"left",
        "1e300": b"1e300",
        "400 digits": b"9" * 400,
        "nothing": b"",
    }.items():
        yield (
            f"coordinate {name} ascii.ply",
            text.replace(b"0.1", raw, 1),
            TOLD if name == "400 digits" else REFUSED if name not in ("nan", "inf") else EITHER,
        )
    for name, raw in {
        "-1": b"-1",
        "8": b"8",
        "10^9": b"1000000000",
        "10^20": b"9" * 20,
        "a word": b"x",
        "1.5": b"1.5",
    }.items():
        yield f"index {name} ascii.ply", b"".join(lines[:-1]) + b"3 0 1 " + raw + b"\n", REFUSED
    for name, row in {
        "2 corners": b"2 0 1",
        "0 corners": b"0",
        "-3 corners": b"-3 0 1 2",
        "4 of 3": b"4 0 1 2",
        "10^9 corners": b"1000000000 0 1 2",
    }.items():
        yield (
            f"face of {name} ascii.ply",
            b"".join(lines[:-1]) + row + b"\n",
            REFUSED if name not in ("2 corners", "0 corners") else EITHER,
        )
    yield "rows too many ascii.ply", text + b"3 0 1 2\n" * 3, EITHER
    yield "no end of the header ascii.ply", text.replace(b"end_header\n", b""), REFUSED
    yield (
        "header of 5 MB ascii.ply",
        text.replace(b"element vertex", b"comment " + b"x" * 5_000_000 + b"\nelement vertex"),
        EITHER,
    )
    yield (
        "100,000 properties ascii.ply",
        text.replace(b"element face", b"".join(b"property float p%d\n" % n for n in range(100_000)) + b"element face"),
        REFUSED,
    )
    yield "unknown format ascii.ply", text.replace(b"ascii 1.0", b"ternary 1.0"), REFUSED
    yield "unknown type ascii.ply", text.replace(b"property float x", b"property quad x"), REFUSED
    yield "no x ascii.ply", text.replace(b"property float x", b"property float q"), REFUSED
    yield "x twice ascii.ply", text.replace(b"property float y", b"property float x"), REFUSED
    yield "x a list ascii.ply", text.replace(b"property float x", b"property list uchar float x"), REFUSED
    yield "ply alone ascii.ply", b"ply\n", REFUSED
    yield "header alone ascii.ply", ply_header("ascii", 0, 0), REFUSED
    yield "faces of vertices that are none ascii.ply", ply_header("ascii", 0, 1) + b"3 0 1 2\n", REFUSED
    yield "vertices after faces ascii.ply", _faces_first(box), EITHER
    yield "escape codes ascii.ply", text.replace(b"property float x", b"property \x1b[31mfloat\x07 x"), REFUSED
    yield "format little body ascii ply.ply", text.replace(b"ascii", b"binary_little_endian"), REFUSED
    yield "format ascii body little ply.ply", ply_binary(box).replace(b"binary_little_endian", b"ascii"), REFUSED
    yield "face of 255 corners little.ply", ply_binary(box)[:-13] + struct.pack("<B3i", 255, 0, 1, 2), REFUSED
    yield "index 8 little.ply", ply_binary(box)[:-4] + struct.pack("<i", 8), REFUSED
    yield "index -1 little.ply", ply_binary(box)[:-4] + struct.pack("<i", -1), REFUSED
    yield "bytes after the end little.ply", ply_binary(box) + b"more" * 100, EITHER
    yield "CRLF in the header little.ply", _crlf_header(ply_binary(box)), EITHER
    bad = box.vertices.copy()
    for name, value in {"nan": np.nan, "inf": np.inf, "1e38": 1e38, "1e-20": 1e-20}.items():
        bad[0, 0] = value
        yield f"coordinate {name} little.ply", ply_binary(Shape(bad, box.faces)), EITHER
    bad = np.full_like(box.vertices, np.nan)
    yield "every coordinate nan little.ply", ply_binary(Shape(bad, box.faces)), REFUSED
    yield "every vertex in one place little.ply", ply_binary(Shape(np.zeros_like(bad), box.faces)), EITHER
    yield "one vertex no face ascii.ply", ply_header("ascii", 1, 0) + b"0 0 0\n", EITHER


def _short(count: str) -> str:
    return count if len(count) < 25 else f"{len(count)} digits"


def _faces_first(box: Shape) -> bytes:
    head = b"ply\nformat ascii 1.0\nelement face 12\nproperty list uchar int vertex_indices\nelement vertex 8\n"
    head += b"property float x\nproperty float y\nproperty float z\nend_header\n"
    return (
        head
        + "".join("3 " + " ".join(map(str, f)) + "\n" for f in box.faces).encode()
        + "".join(" ".join(map(str, p)) + "\n" for p in box.vertices).encode()
    )


def _crlf_header(good: bytes) -> bytes:
    head, body = good.split(b"end_header\n", 1)
    return (head + b"end_header\n").replace(b"\n", b"\r\n") + body


def clouds() -> Iterator[Broken]:
    """PCD and XYZ."""
    box = cube()
    text, binary = pcd_ascii(box), pcd_binary(box)
    yield "POINTS 3 and one line ascii.pcd", pcd_header(3, "ascii") + b"1 2 3\n", REFUSED
    yield "POINTS 3 and no line ascii.pcd", pcd_header(3, "ascii"), REFUSED
    yield "two numbers in a line ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\n4 5\n", REFUSED
    yield "a word ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\n4 five 6\n", REFUSED
    yield "nan ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\nnan nan nan\n", EITHER
    yield "every point nan ascii.pcd", pcd_header(2, "ascii") + b"nan nan nan\nnan nan nan\n", REFUSED
    for count in ("1000000000", "-1", "1.5", "many", "9" * 400, "0"):
        yield (
            f"POINTS {_short(count)} ascii.pcd",
            text.replace(b"POINTS 8", b"POINTS " + count.encode()).replace(b"WIDTH 8", b"WIDTH " + count.encode()),
            REFUSED,
        )
        yield (
            f"POINTS {_short(count)} binary.pcd",
            binary.replace(b"POINTS 8", b"POINTS " + count.encode()).replace(b"WIDTH 8", b"WIDTH " + count.encode()),
            REFUSED,
        )
    yield "WIDTH disagrees ascii.pcd", text.replace(b"WIDTH 8", b"WIDTH 5"), EITHER
    yield "no x ascii.pcd", pcd_header(1, "ascii", "a b c") + b"1 2 3\n", REFUSED
    yield "no FIELDS ascii.pcd", text.replace(b"FIELDS x y z\n", b""), REFUSED
    yield "unknown DATA ascii.pcd", text.replace(b"DATA ascii", b"DATA magic"), REFUSED
    yield "DATA compressed binary.pcd", binary.replace(b"DATA binary", b"DATA binary_compressed"), REFUSED
    yield (
        "compressed claims 4 GB binary.pcd",
        pcd_header(8, "binary_compressed") + struct.pack("<II", 10, 2**32 - 1) + bytes(10),
        REFUSED,
    )
    yield (
        "compressed of 10^9 binary.pcd",
        pcd_header(10**9, "binary_compressed") + struct.pack("<II", 10, 12 * 10**9 % 2**32) + bytes(10),
        REFUSED,
    )
    yield "size 3 binary.pcd", pcd_header(8, "binary", size="3 3 3") + bytes(96), REFUSED
    yield "size 10^9 binary.pcd", pcd_header(8, "binary", size="1000000000 4 4") + bytes(96), REFUSED
    yield "type Q binary.pcd", pcd_header(8, "binary", kind="Q Q Q") + bytes(96), REFUSED
    yield "count -1 binary.pcd", binary.replace(b"COUNT 1 1 1", b"COUNT -1 1 1"), REFUSED
    yield "count 10^9 binary.pcd", binary.replace(b"COUNT 1 1 1", b"COUNT 1000000000 1 1"), REFUSED
    for name, content in {
        "two numbers": b"1 2\n3 4\n",
        "a word": b"1 2 3\nx y z\n",
        "ragged": b"1 2 3\n4 5 6 7 8\n",
        "nan": b"nan nan nan\n",
        "commas": b"1,2,3\n4,5,6\n",
        "comments alone": b"# none\n",
        "1e300": b"1e300 0 0\n1 2 3\n",
        "JSON": b"{}",
    }.items():
        yield f"{name} points.xyz", content, REFUSED if name not in ("ragged", "commas") else EITHER


def objs() -> Iterator[Broken]:
    """OBJ counts from 1, or back from the last by negative numbers."""
    good = meshes.obj(cube())
    for name, face in {
        "0 1 2": b"0 1 2",
        "9": b"1 2 9",
        "-9": b"-1 -2 -9",
        "10^20": b"1 2 99999999999999999999",
        "a word": b"a b c",
        "1.5": b"1.5 2 3",
        "two corners": b"1 2",
        "10^9": b"1 2 1000000000",
    }.items():
        yield f"f {name} cube.obj", good + b"f " + face + b"\n", REFUSED
    for name, row in {
        "one number": b"v 1",
        "no number": b"v",
        "a word": b"v a b c",
        "nan": b"v nan 0 0",
        "inf": b"v inf 0 0",
        "400 digits": b"v " + b"9" * 400 + b" 0 0",
    }.items():
        yield f"last v {name} cube.obj", good + row + b"\n", EITHER if name in ("nan", "inf", "400 digits") else REFUSED
    yield "texture 0 cube.obj", good + b"vt 0 0\nf 1/0/0 2/0/0 3/0/0\n", EITHER
    yield "mtllib out cube.obj", b"mtllib ../outside/mesh.ply\nusemtl x\n" + good, EITHER
    yield "mtllib /dev/zero cube.obj", b"mtllib /dev/zero\nusemtl x\n" + good, EITHER
    yield "mtllib with escape codes cube.obj", b"mtllib \x1b[31mred.mtl\nusemtl x\n" + good, EITHER
    yield "vertices alone cube.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", EITHER
    yield "faces alone cube.obj", b"f 1 2 3\n", REFUSED
    yield "a line of 20 MB cube.obj", good + b"f " + b"1 2 3 " * 3_000_000 + b"\n", EITHER
    yield "a face of 5000 corners cube.obj", good + b"f " + b"1 2 3 " * 1700 + b"\n", EITHER


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


def glbs() -> Iterator[Broken]:
    """glTF's binary form: counts, offsets and addresses in its JSON."""
    told, body = glb_json(cube())
    whole = glb_file(told, body)

    def changed(*path: str | int, value: object) -> bytes:
        copy = json.loads(json.dumps(told))
        inner = copy
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value
        return glb_file(copy, body)

    yield "count 10^9 cube.glb", changed("accessors", 0, "count", value=10**9), REFUSED
    yield "count -1 cube.glb", changed("accessors", 0, "count", value=-1), REFUSED
    yield "indices 10^9 cube.glb", changed("accessors", 1, "count", value=3 * 10**9), REFUSED
    yield "offset beyond cube.glb", changed("bufferViews", 1, "byteOffset", value=10**9), REFUSED
    yield "offset -5 cube.glb", changed("bufferViews", 0, "byteOffset", value=-5), REFUSED
    yield "view 9 cube.glb", changed("accessors", 0, "bufferView", value=9), REFUSED
    yield "component 9 cube.glb", changed("accessors", 0, "componentType", value=9), REFUSED
    yield "VEC2 cube.glb", changed("accessors", 0, "type", value="VEC2"), REFUSED
    yield "node of itself cube.glb", changed("nodes", 0, value={"mesh": 0, "children": [0]}), REFUSED
    yield "mesh 7 cube.glb", changed("nodes", 0, "mesh", value=7), REFUSED
    yield (
        "a file outside cube.glb",
        changed("buffers", 0, value={"byteLength": 100, "uri": "outside/mesh.ply"}),
        REFUSED,
    )
    yield (
        "a web address cube.glb",
        changed("buffers", 0, value={"byteLength": 100, "uri": "http://127.0.0.1:9/x.bin"}),
        REFUSED,
    )
    yield "no meshes cube.glb", changed("meshes", value=[]), REFUSED
    yield (
        "scale nan cube.glb",
        glb_file(json.dumps(told).replace('{"mesh": 0}', '{"mesh": 0, "scale": [NaN, 1, 1]}').encode(), body),
        REFUSED,
    )
    yield "a list cube.glb", glb_file(b"[]", body), REFUSED
    yield "100,000 lists cube.glb", glb_file(b"[" * 100_000, body), REFUSED
    yield "length 4 GB cube.glb", whole[:8] + b"\xff\xff\xff\xff" + whole[12:], EITHER
    yield "chunk of 4 GB cube.glb", whole[:12] + b"\xff\xff\xff\xff" + whole[16:], REFUSED
    yield "version 9 cube.glb", whole[:4] + struct.pack("<I", 9) + whole[8:], REFUSED
    outside = cube().faces.astype("<u4")
    outside[0, 0] = 99
    yield "index 99 cube.glb", glb_file(told, cube().vertices.astype("<f4").tobytes() + outside.tobytes()), REFUSED


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
        out = words[-1] if command == "to glb" else "out"
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
