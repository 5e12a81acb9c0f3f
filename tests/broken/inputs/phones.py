"""Recordings of phones and for splats: nerfstudio's folders, Stray Scanner's; archives that are none or lie."""

import io
import json
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from broken.case import ACCEPTED, EITHER, REFUSED, Case
from broken.foreign import odometry, transforms
from broken.inputs.foreign import RUNS, THINGS, of, put, text
from broken.odd_values import NUMBERS, whole, with_raw


def splats() -> Iterator[Case]:
    kind, file = "nerfstudio", "transforms.json"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, (), quick=True)
    for name, content in whole(transforms()):
        yield from of(kind, name, text(file, content), REFUSED, (file,), ("convert", "info"))
    for path in (("fl_x",), ("frames", 1, "transform_matrix", 0, 3), ("w",), ("cx",)):
        for name, raw in NUMBERS.items():
            # a principal point and a size may stand beside what is told of depth: large ones are doubtful, not wrong
            yield from of(kind, f"{path[-1]} {name}", text(file, with_raw(transforms(), path, raw)), EITHER, (file,),
                          ("convert",))  # fmt: skip
    for name, place in {"leads out": "../../outside/good_depth", "is absolute": "/etc/passwd", "is empty": ""}.items():
        given = transforms()
        given["frames"][1]["depth_file_path"] = place
        right = EITHER if not place else REFUSED
        yield from of(kind, f"a name {name}", text(file, json.dumps(given)), right, (file,), ("convert", "info"),
                      quick=name == "leads out")  # fmt: skip
    for name, thing in THINGS.items():
        right = REFUSED if name not in ("missing",) else EITHER
        yield from of(kind, f"depth {name}", put("depths/1.png", thing), right, ("1.png",), ("convert",))


def phones() -> Iterator[Case]:
    kind = "Stray Scanner"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, (), quick=True)
    for name, content in {
        "a word": odometry().replace("10.0", "ten", 1),
        "a row cut": odometry()[:-6],
        "no rows": odometry().split("\n")[0],
        "empty": "",
        "another head": "a, b\n1, 2\n",
        "quaternion 0": odometry().replace("0, 0, 0, 1", "0, 0, 0, 0"),
        "1e300": odometry().replace(", 0, 0, 0, 0", ", 1e300, 0, 0, 0", 1),
    }.items():
        yield from of(kind, f"pose {name}", text("odometry.csv", content), EITHER, (), ("convert", "info"))
    for name, content in {"two rows": "1, 0, 1\n0, 1, 1\n", "zeros": "0,0,0\n0,0,0\n0,0,0\n", "empty": ""}.items():
        yield from of(
            kind, f"matrix {name}", text("camera_matrix.csv", content), REFUSED, ("camera_matrix",), ("convert",)
        )
    for name, thing in THINGS.items():
        yield from of(kind, f"depth {name}", put("depth/000001.png", thing), EITHER, (), ("convert",))
    yield from of(kind, "video of a play list", text("rgb.mp4", "#EXTM3U\nhttp://127.0.0.1:9/x.ts\n"), EITHER, ())
    yield from of(kind, "video missing its end", text("rgb.mp4", b"\0\0\0\x18ftypmp42" + bytes(40)), EITHER, ())


def dumps() -> Iterator[Case]:
    kind = "libfreenect2"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, (), ("convert", "info"), quick=True)
    for name, thing in THINGS.items():  # what has another size belongs to something else
        yield from of(kind, f"depth {name}", put("1.bin", thing), EITHER, (), ("convert", "info"))
    for name, word in {"NaN": b"\0\0\xc0\x7f", "infinite": b"\0\0\x80\x7f", "huge": b"\xff\xff\x7f\x7f"}.items():
        content = word * (424 * 512)
        yield from of(kind, f"depth all {name}", text("1.bin", content), EITHER, (), ("convert", "info"))
        yield from of(kind, f"first depth all {name}", text("0.bin", content), REFUSED, ("rec",), ("convert",))


def good_archives() -> Iterator[tuple[str, bytes, list[str]]]:
    """Name, content, and further words of archives of two frames each, not packed: a changed byte stays one."""
    lens = {"fx": 144.0, "fy": 144.0, "cx": 80.0, "cy": 60.0}
    metadata = {"w": 160, "h": 120, "dw": 160, "dh": 120, "K": [144, 0, 0, 0, 144, 0, 80, 60, 1], "fps": 30}
    metadata |= {"frameTimestamps": [1.0, 1.1], "poses": [[0, 0, 0, 1, 0, 0, 0.1 * n] for n in range(2)]}
    metres = np.full((120, 160), 1.2, "<f4").tobytes()
    # LZFSE's block that is not packed
    depth = b"bvx-" + struct.pack("<I", len(metres)) + metres + b"bvx$"
    frames = {f"rgbd/{n}.depth": depth for n in range(2)}
    yield "phone.r3d", _archive({"metadata": json.dumps(metadata).encode(), **frames}, zipfile.ZIP_STORED), []
    turn = {f"t_{row}{column}": float(row == column) for row in range(3) for column in range(4)}
    camera = json.dumps({**lens, "width": 160, "height": 120, "timestamp": 1, **turn}).encode()
    png = cv2.imencode(".png", np.full((120, 160), 1200, np.uint16))[1].tobytes()
    members = {f"keyframes/cameras/{n}.json": camera for n in (1000, 2000)}
    members |= {f"keyframes/depth/{n}.png": png for n in (1000, 2000)}
    yield "polycam.zip", _archive(members, zipfile.ZIP_STORED), []


def _archive(members: dict[str, bytes], packed: int = zipfile.ZIP_DEFLATED) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", packed) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return made.getvalue()


def archives() -> Iterator[Case]:
    metadata = {"w": 160, "h": 120, "dw": 160, "dh": 120, "K": [144, 0, 0, 0, 144, 0, 80, 60, 1]}
    huge = metadata | {"dw": 65535, "dh": 65535}
    things = {
        "no metadata": _archive({"rgbd/0.depth": b"bvx$"}),
        "no depth": _archive({"metadata": json.dumps(metadata).encode()}),
        "depth of nothing": _archive({"metadata": json.dumps(metadata).encode(), "rgbd/0.depth": b"bvx$"}),
        "depth that claims 4 GB": _archive(
            {"metadata": json.dumps(metadata).encode(), "rgbd/0.depth": b"bvxn" + b"\xff" * 12 + b"bvx$"}
        ),
        "huge": _archive({"metadata": json.dumps(huge).encode(), "rgbd/0.depth": b"bvx$"}),
        "no JSON": _archive({"metadata": b"{", "rgbd/0.depth": b"bvx$"}),
        "names that lead out": _archive({"../metadata": b"{}", "../rgbd/0.depth": b"bvx$"}),
        "a bomb": _archive({"metadata": b" " * 30_000_000 + b"{}", "rgbd/0.depth": b"bvx$"}),
        "cut": _archive({"metadata": json.dumps(metadata).encode(), "rgbd/0.depth": b"bvx$"})[:-30],
    }
    for name, content in things.items():
        for run, words in RUNS.items():

            def make(place: Path, content: bytes = content, words: list[str] = words) -> list[str]:
                (place / "rec").write_bytes(content)
                return words

            yield Case(f"archive: {name}: {run}", make, REFUSED, ("rec", "metadata", "0.depth"), quick=name == "huge")


def cases() -> Iterator[Case]:
    yield from splats()
    yield from phones()
    yield from dumps()
    yield from archives()
