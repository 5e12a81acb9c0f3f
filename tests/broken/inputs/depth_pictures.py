"""Depth images that are no 16-bit grey PNG of the camera's size, or lie about what they are."""

import struct
import zlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from broken import bases, pictures
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import SKIPPING, Break, Edit, crossed
from broken.odd_files import NO_FILE, cuts

READERS = ("convert", "info", "reconstruct", "turntable", "evaluate", "depth", "explain")
WHOLE = ("convert",)
SURE = ("convert", "reconstruct", "evaluate", "turntable", "depth", "explain")
FIRST = "depth/000000.png"


def first(content: bytes) -> Edit:
    """Another first image."""
    return lambda rec: (rec / FIRST).write_bytes(content)


def every(content: bytes) -> Edit:
    """Every image another."""

    def edit(rec: Path) -> None:
        for path in sorted((rec / "depth").iterdir()):
            path.write_bytes(content)

    return edit


def resized(width: int, height: int, content: bytes) -> Edit:
    """Every image another, and a camera.json that agrees with its size."""

    def edit(rec: Path) -> None:
        every(content)(rec)
        bases.write_json(
            rec / "camera.json", bases.CAMERA | {"width": width, "height": height, "cx": width / 2, "cy": height / 2}
        )

    return edit


@cache
def bomb() -> bytes:
    """800 MB of zeros in some 800 kB."""
    return pictures.whole(20000, 20000)


def other_files(good: bytes) -> dict[str, bytes]:
    """What other programs call a picture, and what is none."""
    import cv2

    grey = np.full((120, 160), 80, np.uint8)
    coded = {ending: cv2.imencode(f".{ending}", grey)[1].tobytes() for ending in ("jpg", "bmp", "tiff", "webp", "pgm")}
    return coded | {
        "text": b"no picture\n",
        "gif": b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x01\0\x01\0\0\x02\x02D\x01\0;",
        "signature alone": pictures.SIGNATURE,
        "zeros": bytes(5000),
        "numpy": b"\x93NUMPY\x01\0" + good,
        "svg": b"<svg xmlns='http://www.w3.org/2000/svg'/>",
        "a program": b"#!/bin/sh\ntouch /tmp/owned\n",
        "PNG after text": b"text\n" + good,
    }


def kinds() -> Iterator[tuple[str, bytes, Expected]]:
    """Pictures of every kind that a PNG may be."""
    for bits, kind, name in (
        (8, 0, "8-bit grey"),
        (16, 2, "16-bit colour"),
        (8, 2, "8-bit colour"),
        (16, 6, "16-bit with alpha"),
        (8, 6, "8-bit with alpha"),
        (16, 4, "16-bit grey with alpha"),
        (8, 4, "8-bit grey with alpha"),
        (1, 0, "1 bit"),
        (4, 0, "4 bits"),
    ):
        yield name, pictures.packed(160, 120, bits, kind), REFUSED
    palette = pictures.chunk(b"PLTE", bytes(range(48)))
    yield "palette", pictures.packed(160, 120, 8, 3, palette), REFUSED
    yield "palette of 4 bits", pictures.packed(160, 120, 4, 3, palette), REFUSED


def damaged(good: bytes) -> Iterator[tuple[str, bytes, Expected]]:
    """A good file with damage at one place."""
    counts = bases.depth_counts()
    at = good.index(b"IDAT")
    yield "wrong check sum of the header", good[:29] + b"\0\0\0\0" + good[33:], REFUSED
    yield "wrong check sum of the data", good[:-16] + b"\0\0\0\0" + good[-12:], EITHER
    yield "no end", good[:-12], EITHER
    yield "data overwritten", good[: at + 20] + b"\xff" * 200 + good[at + 220 :], REFUSED
    yield "bytes after the end", good + b"more" * 1000, EITHER
    yield "no data", pictures.SIGNATURE + pictures.header(160, 120) + pictures.chunk(b"IEND", b""), REFUSED
    half = zlib.compress(pictures.rows(counts[:60]))
    yield (
        "half the rows",
        pictures.SIGNATURE + pictures.header(160, 120) + pictures.chunk(b"IDAT", half) + pictures.chunk(b"IEND", b""),
        REFUSED,
    )
    yield "filter of no name", pictures.claimed(160, 120, data=(b"\x09" + b"\1\0" * 160) * 120), REFUSED
    yield "width 0", pictures.claimed(0, 120), REFUSED
    yield (
        "chunk of 2 GB",
        pictures.SIGNATURE + pictures.header(160, 120) + struct.pack(">I", 2**31 - 1) + b"IDAT" + b"x" * 100,
        REFUSED,
    )
    yield "unknown compression", good[:26] + b"\x07" + good[27:], REFUSED
    for name, extra in {
        "broken profile": pictures.chunk(b"iCCP", b"x\0\0broken"),
        "gamma 0": pictures.chunk(b"gAMA", bytes(4)),
        "odd sBIT": pictures.chunk(b"sBIT", b"\x63"),
        "transparent 0": pictures.chunk(b"tRNS", b"\x03\xe8"),
        "broken chromaticities": pictures.chunk(b"cHRM", bytes(32)),
        "text that unpacks to 50 MB": pictures.chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes(50_000_000))),
        "unknown critical chunk": pictures.chunk(b"QQQQ", b"what"),
    }.items():
        yield name, pictures.png(counts, before=extra), EITHER


def one() -> Iterator[Break]:
    """The first image is wrong."""
    good = pictures.png(bases.depth_counts())
    here = (FIRST, "000000.png")
    for name, content in other_files(good).items():
        yield Break(name, first(content), REFUSED, here, WHOLE, SKIPPING, quick=name in ("text", "jpg"))
    for name, content, expected in [*kinds(), *damaged(good)]:
        told = SKIPPING if expected is REFUSED else ()
        yield Break(name, first(content), expected, here, WHOLE, told, quick=name in ("half the rows", "8-bit grey"))
    for at, content in cuts(good, 12):
        yield Break(f"cut at {at}", first(content), REFUSED, here, WHOLE, SKIPPING)
    yield Break("interlaced", first(pictures.interlaced(bases.depth_counts())), ACCEPTED, here, ("convert",))
    for name, put in NO_FILE.items():
        yield Break(name, lambda rec, put=put: put(rec / FIRST), REFUSED, here, WHOLE, SKIPPING)  # type: ignore[misc]
    small = bases.depth_counts()[:60, :80]
    yield Break("a smaller one", first(pictures.png(small)), REFUSED, (*here, "camera.json"), WHOLE, SKIPPING)


def all_of_them() -> Iterator[Break]:
    """Every image is wrong in one way, as a wrong export leaves them."""
    counts = bases.depth_counts()
    here = ("depth", "camera.json", "rec")
    yield Break("every one 8-bit", every(pictures.png((counts // 256).astype(np.uint8))), REFUSED, here, SURE)
    yield Break(
        "every one missing", every(pictures.png(np.zeros_like(counts))), REFUSED, here, ("reconstruct", "turntable")
    )
    yield Break(
        "every one 65535", every(pictures.png(np.full_like(counts, 65535))), REFUSED, here, ("reconstruct", "turntable")
    )
    yield Break("one pixel", every(_one_pixel(counts)), EITHER, here)
    yield Break("another size", every(pictures.png(counts[:60, :80])), REFUSED, here, SURE)
    for factor in (10, 0.1, 0.01):
        scaled = np.clip(counts.astype(float) * factor, 0, 65534).astype(np.uint16)
        yield Break(f"scaled by {factor}", every(pictures.png(scaled)), EITHER, here)
    noise = np.random.default_rng(1).integers(0, 65536, counts.shape).astype(np.uint16)
    yield Break("noise", every(pictures.png(noise)), EITHER, here)
    for size in (20000, 100000, 2**31 - 1):
        content = pictures.claimed(size, size)
        yield Break(f"claim {size} x {size}", every(content), REFUSED, here, SURE)
        yield Break(
            f"claim {size} x {size}, the camera agrees",
            resized(size, size, content),
            REFUSED,
            here,
            SURE,
            quick=size == 20000,
        )
    yield Break(
        "bomb of 20000 x 20000, the camera agrees", lambda rec: resized(20000, 20000, bomb())(rec), REFUSED, here, SURE
    )
    yield Break("1 x 1, the camera agrees", resized(1, 1, pictures.png(counts[:1, :1])), EITHER, here)
    yield Break(
        "60000 x 1, the camera agrees",
        resized(60000, 1, pictures.png(np.full((1, 60000), 1000, np.uint16))),
        EITHER,
        here,
    )


def _one_pixel(counts: np.ndarray) -> bytes:
    alone = np.zeros_like(counts)
    alone[60, 80] = 1000
    return pictures.png(alone)


def cases() -> Iterator[Case]:
    yield from crossed("depth image", one(), READERS)
    yield from crossed("depth images", all_of_them(), READERS)
