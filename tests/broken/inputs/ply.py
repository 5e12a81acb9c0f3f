"""PLY by its definition: a header that promises, and a body that keeps it or not."""

import struct
from collections.abc import Iterator

import numpy as np

from broken.case import EITHER, REFUSED, TOLD, Expected
from broken.meshes import (
    Shape,
    cube,
    ply_ascii,
    ply_binary,
    ply_header,
)

Broken = tuple[str, bytes, Expected]  # name that ends with the file's, content, what is right


def plys() -> Iterator[Broken]:
    """PLY by its definition: a header that promises, and a body that keeps it or not."""
    box, text = cube(), ply_ascii(cube())
    lines = text.splitlines(keepends=True)
    yield "4 of 12 faces ascii.ply", b"".join(lines[:-8]), REFUSED
    yield "5 of 8 vertices ascii.ply", b"".join(lines[:-15]), REFUSED
    for count in ("1000000000", "99999999999999999999", "-1", "1.5", "many", "9" * 400, "4294967297"):
        yield (
            f"{shortened(count)} faces claimed ascii.ply",
            text.replace(b"element face 12", f"element face {count}".encode()),
            REFUSED,
        )
        yield (
            f"{shortened(count)} vertices claimed ascii.ply",
            text.replace(b"element vertex 8", f"element vertex {count}".encode()),
            REFUSED,
        )
        yield (
            f"{shortened(count)} faces claimed little.ply",
            ply_binary(box).replace(b"element face 12", f"element face {count}".encode()),
            REFUSED,
        )
        yield (
            f"{shortened(count)} vertices claimed little.ply",
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
            TOLD if name in ("400 digits", "1e300") else REFUSED if name not in ("nan", "inf") else EITHER,
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


def shortened(count: str) -> str:
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
