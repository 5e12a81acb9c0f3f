"""Points of `compare --seen`, masks of `turntable --mask`, and pictures of colour and infrared."""

import io
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from broken import bases, pictures
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import Break, Edit, crossed, over_file
from broken.inputs.depth_pictures import damaged, kinds, other_files
from broken.inputs.sensors import Owned, claim, saved
from broken.meshes import ball, cube, pcd_header, ply_ascii, ply_header
from broken.odd_files import NO_FILE, cuts

SEEN = {"compare": ["compare", "good.ply", "good.ply", "--seen", "FILE", "-o", "out", "--no-report"]}
MASK = {"turntable": ["turntable", "turntable", "--mask", "FILE", "-o", "out", "--no-report", "--voxel", "0.008"]}


def archive(members: dict[str, bytes], packing: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A .npz is a zip of .npy files."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", packing) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return memory.getvalue()


@cache
def seven_gb() -> bytes:
    """7 GB of zeros in 7 MB, as people pack them."""
    memory = io.BytesIO()
    with (
        zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file,
        file.open("points.npy", "w", force_zip64=True) as member,
    ):
        member.write(claim("(300000000, 3)")[:-800])
        block = bytes(1 << 24)
        for _ in range(7_200_000_000 // len(block)):
            member.write(block)
    return memory.getvalue()


def points() -> Iterator[tuple[str, bytes | Edit, Expected]]:
    good = saved(ball().vertices)
    yield "good points.npz", archive({"points.npy": good}), ACCEPTED
    yield "good points.ply", ply_ascii(ball()), ACCEPTED
    arrays = {
        "a pickle": saved(np.array([Owned()], dtype=object)),
        "nan": saved(np.full((5, 3), np.nan)),
        "two columns": saved(np.zeros((5, 2))),
        "flat": saved(np.zeros(15)),
        "none": saved(np.zeros((0, 3))),
        "words": saved(np.array([["a"] * 3])),
        "complex": saved(np.zeros((5, 3), complex)),
        "claims 10^18": claim("(1000000000, 1000000000)"),
        "claims 8 GB": claim("(333333333, 3)"),
        "1e300": saved(np.full((5, 3), 1e300)),
        "cut": good[:-100],
        "empty": b"",
        "text": b"1 2 3\n",
    }
    for name, content in arrays.items():
        yield f"{name} points.npz", archive({"points.npy": content}), REFUSED
    yield "no member points.npz", archive({}), REFUSED
    yield "other names points.npz", archive({"a.npy": good, "b.npy": good}), EITHER
    yield "name that reaches out points.npz", archive({"../../outside/x.npy": good}), EITHER
    yield "1000 members points.npz", archive({f"{n}.npy": good[:200] for n in range(1000)}), REFUSED
    yield "name with escape codes points.npz", archive({"\x1b[31mred.npy": good}), EITHER
    yield "7 GB in a zip points.npz", lambda path: path.write_bytes(seven_gb()), REFUSED
    yield "bare npy points.npz", good, EITHER
    packed = archive({"points.npy": good})
    for at, content in cuts(packed, 4):
        yield f"cut at {at} points.npz", content, REFUSED
    yield "wrong check sum points.npz", packed.replace(packed[14:18], b"\0\0\0\0"), REFUSED
    yield "size lies points.npz", packed[:22] + b"\xff\xff\xff\x7f" + packed[26:], EITHER
    yield "encrypted flag points.npz", packed[:6] + b"\x01" + packed[7:], EITHER
    yield "a PNG points.npz", pictures.png(np.zeros((4, 4), np.uint16)), REFUSED
    yield "none ply points.ply", ply_header("ascii", 0, 0), REFUSED
    yield "far from the reference points.ply", ply_ascii(type(cube())(cube().vertices + 1000, cube().faces)), EITHER
    yield "10^9 claimed points.ply", ply_header("ascii", 10**9, 0) + b"0 0 0\n", REFUSED
    yield "a cloud as PCD points.pcd", pcd_header(3, "ascii") + b"1 2 3\n", REFUSED


def masks() -> Iterator[tuple[str, bytes, Expected]]:
    good = np.full((120, 160), 255, np.uint8)
    yield "all of it mask.png", pictures.png(good), EITHER
    yield "nothing mask.png", pictures.png(good * 0), REFUSED
    yield "other size mask.png", pictures.png(good[:60]), REFUSED
    yield "claims 20000 x 20000 mask.png", pictures.claimed(20000, 20000, 8), REFUSED
    yield "16 bits mask.png", pictures.packed(160, 120, 16, 0), EITHER
    for name, content in other_files(pictures.png(good)).items():
        yield f"{name} mask.png", content, EITHER if name in ("jpg", "bmp", "tiff", "webp", "pgm", "gif") else REFUSED
    for name, content, expected in damaged(pictures.png(bases.depth_counts())):
        yield f"{name} mask.png", content, expected if expected is REFUSED else EITHER


def coloured() -> Iterator[Break]:
    """Colour images of a recording: read where colour is wanted, and by `convert`, which copies."""
    where = ("rgb/000000.png", "000000.png", "rgb.txt", "rgb", "olour")
    good = pictures.png(np.full((120, 160, 3), 90, np.uint8), 2)

    def first(content: bytes) -> Edit:
        return lambda rec: (rec / "rgb" / "000000.png").write_bytes(content)

    for name, content in other_files(good).items():
        yield Break(name, first(content), EITHER, where)
    for name, content, _ in [*kinds(), *damaged(good)]:
        yield Break(name, first(content), EITHER, where)
    yield Break("other size", first(pictures.png(np.zeros((10, 10, 3), np.uint8), 2)), EITHER, where)
    yield Break(
        "claims 20000 x 20000", first(pictures.claimed(20000, 20000, 8, 2)), REFUSED, where, ("none",), ("turntable",)
    )
    yield Break(
        "bomb of 20000 x 20000", lambda rec: first(small_bomb())(rec), REFUSED, where, ("none",), ("turntable",)
    )
    for name, put in NO_FILE.items():
        yield Break(
            f"is {name}",
            lambda rec, put=put: put(rec / "rgb" / "000000.png"),
            REFUSED if "link" in name or "FIFO" in name else EITHER,
            where,
            ("none",),
            ("convert", "turntable"),
        )  # type: ignore[misc]
        yield Break(
            f"rgb.txt is {name}",
            lambda rec, put=put: put(rec / "rgb.txt"),
            REFUSED,
            where,
            ("none",),
            ("convert", "turntable") if name not in ("no file", "an empty file") else (),
        )  # type: ignore[misc]
    for name, line in {
        "/etc/passwd": "/etc/passwd",
        "outside": "../outside/good_depth",
        "/dev/zero": "/dev/zero",
        "escape codes": "rgb/\x1b[31m.png",
        "missing": "rgb/nothing.png",
    }.items():
        yield Break(
            f"rgb.txt names {name}",
            lambda rec, line=line: (rec / "rgb.txt").write_text(f"0.0 {line}\n", encoding="utf-8"),
            REFUSED,
            (*where, "passwd", "good_depth", "/dev/zero"),
            ("none",),
            ("convert",),
        )  # type: ignore[misc]
    for name, content in {
        "nan": "nan rgb/000000.png\n",
        "a word": "x rgb/000000.png\n",
        "empty": "",
        "a PNG": "\x89PNG",
    }.items():
        yield Break(
            f"rgb.txt {name}",
            lambda rec, content=content: (rec / "rgb.txt").write_text(content, encoding="utf-8"),
            REFUSED if name in ("nan", "a word", "a PNG") else EITHER,
            where,
            ("none",),
            ("convert",),
        )  # type: ignore[misc]


@cache
def small_bomb() -> bytes:
    """1.2 GB of zeros as a colour image."""
    return pictures.whole(20000, 20000, 8, 2)


def cases() -> Iterator[Case]:
    for name, content, expected in points():
        for case in over_file("seen", name, content, SEEN, expected=expected):  # type: ignore[arg-type]
            yield case.as_quick() if name in ("7 GB in a zip points.npz", "a pickle points.npz") else case
    for name, put in NO_FILE.items():
        yield from over_file("seen is", f"{name} points.npz", put, SEEN, expected=REFUSED)
        yield from over_file("mask is", f"{name} mask.png", put, MASK, expected=REFUSED)
    for name, content, expected in masks():
        yield from over_file("mask", name, content, MASK, expected=expected)
    colour = [replace(b, of="turntable") for b in coloured()]
    yield from crossed("colour", colour, ("info", "turntable", "convert"))
    pictures_of_board = [
        Break(
            f"board picture {name}", _board_picture(content), EITHER, ("ir", "rgb", "board", "rec"), of="checkerboard"
        )
        for name, content in other_files(pictures.png(bases.depth_counts())).items()
    ]
    yield from crossed("infrared", pictures_of_board, ("intrinsics",))


def _board_picture(content: bytes) -> Edit:
    def edit(rec: Path) -> None:
        for kind in ("ir", "rgb"):
            for path in sorted((rec / kind).glob("*.png"))[:1]:
                path.write_bytes(content)

    return edit
