"""Recordings of other programs: 7-Scenes, BOP, fakenect, Open3D, plain TUM; and folders that are no recording."""

import json
from collections.abc import Iterator
from pathlib import Path

from broken import bases, pictures
from broken.case import ACCEPTED, EITHER, REFUSED, TOLD, Case, Expected
from broken.crossing import outside
from broken.foreign import (
    UNIT,
    Build,
    bop,
    bop_cameras,
    fakenect,
    freenect2,
    intrinsic,
    nerfstudio,
    open3d,
    seven_scenes,
    stray,
    tum,
)
from broken.odd_files import clear, fifo, folder, link
from broken.odd_values import NUMBERS, whole, with_raw

CAMERA = ["--camera", "camera.json"]


FORMATS: dict[str, tuple[Build, list[str]]] = {
    "7-Scenes": (seven_scenes, CAMERA),
    "BOP": (bop, []),
    "fakenect": (fakenect, []),
    "Open3D": (open3d, []),
    "TUM": (tum, CAMERA),
    "nerfstudio": (nerfstudio, []),
    "Stray Scanner": (stray, []),
    "libfreenect2": (freenect2, []),
}
RUNS = {
    "convert": ["convert", "rec", "out"],
    "info": ["info", "rec"],
    "reconstruct": ["reconstruct", "rec", "-o", "out", "--no-report", "--voxel", "0.02"],
}


def of(
    kind: str,
    name: str,
    edit: Build,
    expected: Expected,
    where: tuple[str, ...],
    runs: tuple[str, ...] = ("convert", "info", "reconstruct"),
    quick: bool = False,
) -> Iterator[Case]:
    build, more = FORMATS[kind]
    for run in runs:

        def make(place: Path, run: str = run) -> list[str]:
            outside(place)
            build(place / "rec")
            bases.write_json(place / "camera.json", bases.CAMERA)
            edit(place / "rec")
            return [*RUNS[run], *more]

        right = expected if run == "convert" else EITHER
        if run == "reconstruct" and expected is REFUSED:
            right = TOLD if name.startswith(("depth", "picture", "pose")) else REFUSED  # one frame may be left out
        yield Case(
            f"{kind}: {name}: {run}",
            make,
            right,
            where if right is not EITHER else (),
            quick=quick and run == "convert",
            weight=3 if run == "reconstruct" else 1,
        )


def text(name: str, content: bytes | str) -> Build:
    return lambda rec: (rec / name).write_bytes(content.encode() if isinstance(content, str) else content)


def put(name: str, thing: Build) -> Build:
    return lambda rec: thing(rec / name)


THINGS: dict[str, Build] = {
    "a FIFO": fifo,
    "a folder": folder,
    "a link to /dev/zero": link("/dev/zero"),
    "a link out": link("../outside/good_depth"),
    "a link to /etc/passwd": link("/etc/passwd"),
    "a link to nothing": link("nothing"),
    "empty": lambda path: path.write_bytes(b""),
    "missing": clear,
    "text": lambda path: path.write_bytes(b"no picture\n"),
    "cut": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "claims 20000 x 20000": lambda path: path.write_bytes(pictures.claimed(20000, 20000)),
}


def scenes_7() -> Iterator[Case]:
    kind, pose, depth = "7-Scenes", "frame-000001.pose.txt", "frame-000001.depth.png"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, ())
    for name, content in {
        "nan": UNIT.replace("1", "nan", 1),
        "a word": UNIT.replace("1", "one", 1),
        "three rows": UNIT[:24],
        "zeros": "0 0 0 0\n" * 4,
        "1e300": UNIT.replace("1", "1e300", 1),
        "mirrored": UNIT.replace("1", "-1", 1),
        "empty": "",
        "17 numbers": UNIT + "5\n",
        "UTF-16": UNIT.encode("utf-16"),
        "5 MB": "1 " * 2_500_000,
    }.items():
        yield from of(
            kind, f"pose {name}", text(pose, content), EITHER if name in ("nan", "UTF-16") else REFUSED, (pose,)
        )
    for name, thing in THINGS.items():
        yield from of(
            kind,
            f"depth {name}",
            put(depth, thing),
            REFUSED if name != "missing" else EITHER,
            (depth,),
            quick=name == "a FIFO",
        )
        if name not in ("claims 20000 x 20000", "cut", "text", "empty"):
            yield from of(
                kind, f"pose {name}", put(pose, thing), REFUSED if name != "missing" else EITHER, (pose,), ("convert",)
            )
    yield from of(
        kind,
        "number of 30 digits",
        lambda rec: (rec / depth).rename(rec / f"frame-{'9' * 30}.depth.png"),
        EITHER,
        ("frame",),
        ("convert", "info"),
    )


def bops() -> Iterator[Case]:
    kind, file = "BOP", "scene_camera.json"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, ())
    for name, content in whole(bop_cameras()):
        yield from of(kind, name, text(file, content), REFUSED, (file,), ("convert", "info"))
    for path in (("1", "cam_K", 0), ("1", "depth_scale")):
        for name, raw in [*NUMBERS.items(), ("0", "0"), ("-1", "-1"), ("1e-300", "1e-300")]:
            yield from of(
                kind,
                f"{path[1]} {name}",
                text(file, with_raw(bop_cameras(), path, raw)),
                REFUSED,
                (file,),
                ("convert",),
                quick=name == "nan",
            )
    for name, raw in {
        "eight": "[1,0,0,0,1,0,0,0]",
        "nested": "[[144,0,79.5],[0,144,59.5],[0,0,1]]",
        "a word": '"K"',
    }.items():
        yield from of(
            kind,
            f"cam_K {name}",
            text(file, with_raw(bop_cameras(), ("1", "cam_K"), raw)),
            REFUSED if name != "nested" else EITHER,
            (file,),
            ("convert", "info"),
        )
    for key in ("-1", "x", "9" * 400, "1.5", "../../outside/good_depth", "\x1b[31m"):
        yield from of(
            kind,
            f"frame {ascii(key)[1:25]}",
            text(file, json.dumps({key: bop_cameras()["0"]})),
            REFUSED if key != "9" * 400 else EITHER,
            (file, "depth", "rec"),
            ("convert", "info"),
        )
    for name, thing in THINGS.items():
        yield from of(
            kind,
            f"depth {name}",
            put("depth/000001.png", thing),
            REFUSED if name != "missing" else EITHER,
            ("000001.png",),
        )
        if name not in ("claims 20000 x 20000",):
            yield from of(kind, f"cameras {name}", put(file, thing), REFUSED, (file, "rec"), ("convert", "info"))


def fakenects() -> Iterator[Case]:
    kind, file = "fakenect", "INDEX.txt"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, ())
    good = "d-1306361010.25-3408212745.pgm"
    for name, content in {
        "empty": "",
        "a word": "hello\n",
        "missing file": "d-1.0-2.pgm\n",
        "/etc/passwd": "/etc/passwd\n",
        "outside": "../outside/good_depth\n",
        "no stamps": "d--.pgm\n",
        "stamp nan": "d-nan-5.pgm\n",
        "NUL": "\0" * 500,
        "UTF-16": (good + "\n").encode("utf-16"),
        "5 kB": "d-" + "9" * 5000 + "-5.pgm\n",
        "escape codes": "d-1.0-\x1b[31m.pgm\n",
        "no UTF-8": b"d-1.0-\xff.pgm\n",
        "dev": "/dev/zero\n",
        "inside twice": f"{good}\n{good}\n",
    }.items():
        yield from of(
            kind,
            f"index {name}",
            text(file, content),
            REFUSED if name not in ("inside twice", "UTF-16") else EITHER,
            (file, "d-", "passwd", "good_depth", "/dev/zero", "rec"),
            ("convert", "info"),
        )
    body = bytes(640 * 480 * 2)
    for name, content in {
        "size 0": b"P5 0 480 65535\n" + body,
        "size 10^9": b"P5 1000000000 1000000000 65535\n" + body,
        "size -1": b"P5 -640 480 65535\n" + body,
        "size words": b"P5 x y z\n" + body,
        "8 bits": b"P5 640 480 255\n" + body,
        "P6": b"P6 640 480 65535\n" + body,
        "header alone": b"P5 640 480 65535\n",
        "half": b"P5 640 480 65535\n" + body[:1000],
        "comment of 5 MB": b"P5 #" + b"x" * 5_000_000 + b"\n640 480 65535\n" + body,
        "400 digits": b"P5 " + b"9" * 400 + b" 480 65535\n" + body,
        "other size": b"P5 64 48 65535\n" + body[: 64 * 48 * 2],
    }.items():
        yield from of(
            kind,
            f"picture {name}",
            text(good, content),
            REFUSED if name not in ("comment of 5 MB",) else EITHER,
            (good, file),
        )
    for name, thing in THINGS.items():
        yield from of(
            kind,
            f"picture {name}",
            put(good, thing),
            REFUSED if name != "missing" else EITHER,
            (good, file),
            quick=name == "a FIFO",
        )
        if name != "claims 20000 x 20000":
            yield from of(kind, f"index is {name}", put(file, thing), REFUSED, (file, "rec"), ("convert", "info"))


def open3ds() -> Iterator[Case]:
    kind, file = "Open3D", "intrinsic.json"
    yield from of(kind, "good", lambda rec: None, ACCEPTED, ())
    for name, content in whole(intrinsic()):
        yield from of(kind, name, text(file, content), REFUSED, (file,), ("convert", "info"))
    for path in (("width",), ("intrinsic_matrix", 0), ("intrinsic_matrix", 6)):
        for name, raw in NUMBERS.items():
            yield from of(
                kind,
                f"{path[0]}{path[1:]} {name}",
                text(file, with_raw(intrinsic(), path, raw)),
                REFUSED,
                (file,),
                ("convert",),
                quick=name == "400 digits",
            )
    for name, raw in {
        "eight": "[144,0,0,0,144,0,79.5,59.5]",
        "a word": '"K"',
        "zeros": "[0,0,0,0,0,0,0,0,0]",
        "row by row": "[144,0,79.5,0,144,59.5,0,0,1]",
    }.items():
        yield from of(
            kind,
            f"matrix {name}",
            text(file, with_raw(intrinsic(), ("intrinsic_matrix",), raw)),
            REFUSED,
            (file,),
            ("convert", "info"),
        )
    for name, thing in THINGS.items():
        yield from of(
            kind,
            f"depth {name}",
            put("depth/000001.png", thing),
            REFUSED if name != "missing" else EITHER,
            ("000001.png", "depth", "color"),
        )
        yield from of(
            kind,
            f"colour {name}",
            put("color/000001.png", thing),
            REFUSED if name != "missing" else EITHER,
            ("000001.png", "depth", "color"),
            ("convert",),
        )
        if name not in ("missing", "claims 20000 x 20000"):
            yield from of(kind, f"camera {name}", put(file, thing), REFUSED, (file, "rec"), ("convert", "info"))
    yield from of(
        kind, "more colour than depth", lambda rec: (rec / "depth" / "000002.png").unlink(), EITHER, ("depth", "color")
    )
    yield from of(kind, "a stranger in depth/", text("depth/notes.txt", "hello"), EITHER, ("notes.txt",))
    yield from of(
        kind,
        "names with escape codes",
        lambda rec: (rec / "depth" / "000002.png").rename(rec / "depth" / "\x1b[31m2.png"),
        EITHER,
        ("depth",),
    )
    yield from of(
        kind,
        "names without UTF-8",
        lambda rec: (rec / "depth" / "000002.png").rename(rec / "depth" / "\udcff2.png"),
        EITHER,
        ("depth",),
    )


def tums() -> Iterator[Case]:
    yield from of("TUM", "good", lambda rec: None, ACCEPTED, ())
    yield from of(
        "TUM",
        "camera.json beside it is a link in a loop",
        lambda rec: (rec / "camera.json").symlink_to("camera.json"),
        EITHER,
        ("camera.json",),
        ("convert", "info"),
    )


def cases() -> Iterator[Case]:
    yield from scenes_7()
    yield from bops()
    yield from fakenects()
    yield from open3ds()
    yield from tums()
