"""Trajectories (groundtruth.txt, --poses) and telemetry.csv."""

import math
from collections.abc import Iterator

from broken import bases
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import Break, Edit, crossed, over_file
from broken.odd_files import NO_FILE, cuts, encodings
from broken.odd_values import LETTERS

OPTION = {"reconstruct": ["reconstruct", "wall", "--poses", "FILE", "-o", "out", "--no-report", "--voxel", "0.02"]}
POSE_READERS = ("stated", "info", "convert", "explain")
POSE = "0.8 0 0 -0.5 -0.5 0.5 0.5"


def trajectory() -> bytes:
    """The good one."""
    return (bases.place() / "wall" / "groundtruth.txt").read_bytes()


def poses() -> Iterator[tuple[str, bytes, Expected]]:
    """Texts of a trajectory; the second line is wrong in most."""
    lines = {
        "nan": "nan 0 0 0 0 0 1",
        "inf": "inf 0 0 0 0 0 1",
        "quaternion of zeros": "0 0 0 0 0 0 0",
        "quaternion nan": "0 0 0 nan 0 0 1",
        "a word": "0 0 zero 0 0 0 1",
        "six numbers": "0 0 0 0 0 1",
        "nine numbers": POSE + " 7 8",
        "nothing": "",
        "1e300": "1e300 0 0 0 0 0 1",
        "quaternion 1e300": "0 0 0 0 0 0 1e300",
        "quaternion 1e-300": "0 0 0 0 0 0 1e-300",
        "400 digits": "9" * 400 + " 0 0 0 0 0 1",
        "decimal commas": "0,8 0 0 0 0 0 1",
        "5 kB": "x" * 5000,
        "escape codes": LETTERS,
        "quaternion far from 1": "0 0 0 5 5 5 5",
        "no number at all": "a b c d e f g",
    }
    either = ("1e300", "nothing")
    good = trajectory().decode().splitlines()
    frame = next(n for n, line in enumerate(good) if not line.startswith("#"))
    for name, line in lines.items():
        told = [*good[:frame], f"{good[frame].split()[0]} {line}", *good[frame + 1 :]]
        yield name, ("\n".join(told) + "\n").encode(), EITHER if name in either else REFUSED
    for name, stamp in {"stamp nan": "nan", "stamp a word": "then", "stamp inf": "inf"}.items():
        yield name, trajectory() + f"{stamp} {POSE}\n".encode(), REFUSED
    yield "stamps fall", "\n".join(reversed(good)).encode(), EITHER
    yield "stamps twice", trajectory() + trajectory(), EITHER
    yield "stamps that match nothing", "".join(f"{n} {POSE}\n" for n in range(5)).encode(), REFUSED
    yield "comments alone", b"# nothing\n", REFUSED
    yield "one pose", (good[frame] + "\n").encode(), EITHER
    yield (
        "every pose the same",
        "".join(f"{line.split()[0]} {POSE}\n" for line in good if not line.startswith("#")).encode(),
        EITHER,
    )
    yield (
        "millimetres",
        "".join(f"{line.split()[0]} 800 0 0 -0.5 -0.5 0.5 0.5\n" for line in good if not line.startswith("#")).encode(),
        EITHER,
    )
    yield "JSON", b'{"poses": []}', REFUSED
    yield "a PNG", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), REFUSED
    for name, content in encodings(trajectory()):
        yield (
            name,
            content,
            {"BOM": ACCEPTED, "CRLF": ACCEPTED, "Latin-1": REFUSED, "surrogates": REFUSED}.get(name, EITHER),
        )
    for at, content in cuts(trajectory(), 4):
        yield f"cut at {at}", content, EITHER


def telemetry() -> Iterator[tuple[str, bytes | None, Expected, tuple[str, ...]]]:
    """Tables of a turntable's log; None in place of a text: made from the good one. Last: whose answer is sure."""
    stamps = [
        line.split()[0]
        for line in (bases.place() / "turntable" / "depth.txt").read_text(encoding="utf-8").splitlines()
        if not line.startswith("#")
    ]
    head = "timestamp,turntable_deg\n"

    def table(value: object, header: str = head) -> bytes:
        return (header + "".join(f"{stamp},{value(n)}\n" for n, stamp in enumerate(stamps))).encode()  # type: ignore[operator]

    users = ("turntable", "convert")
    for name, raw in {
        "nan": "nan",
        "inf": "inf",
        "a word": "half",
        "400 digits": "9" * 400,
        "5 kB": "x" * 5000,
        "escape codes": "\x1b[31m",
        "1e300": "1e300",
        "1e18": "1e18",
    }.items():
        yield f"one angle {name}", table(lambda n, raw=raw: raw if n == 3 else n * 33), REFUSED, ("turntable",)
    yield "one angle missing", table(lambda n: "" if n == 3 else n * 33), EITHER, ()
    yield "every angle the same", table(lambda n: 5), EITHER, ()
    yield "in radians", table(lambda n: n * math.radians(33)), EITHER, ()
    yield "angles 1e300", table(lambda n: "1e300"), REFUSED, ("turntable",)
    for name, content in {
        "no header": "".join(f"{s},5\n" for s in stamps),
        "no stamps": "turntable_deg\n5\n",
        "header alone": head,
        "too few cells": head + f"{stamps[0]}\n",
        "too many cells": head + f"{stamps[0]},1,2,3\n",
        "an open quote": head + f'"{stamps[0]},5\n',
        "semicolons": head.replace(",", ";") + f"{stamps[0]};5\n",
        "stamp nan": head + "nan,5\n",
        "stamp a word": head + "then,5\n",
        "JSON": "{}",
        "blank": "\n\n",
    }.items():
        yield name, content.encode(), REFUSED if name not in ("header alone", "blank") else EITHER, users
    yield "a column twice", table(lambda n: f"{n},{n}", "timestamp,turntable_deg,turntable_deg\n"), REFUSED, users
    yield "stamps that match nothing", (head + "1,5\n2,6\n").encode(), EITHER, ()
    yield "an unknown column", table(lambda n: f"{33 * n},7", "timestamp,turntable_deg,note\n"), ACCEPTED, ("convert",)
    yield "a column of 5 kB", table(lambda n: f"{33 * n},7", f"timestamp,turntable_deg,{'x' * 5000}\n"), EITHER, ()
    yield (
        "a column with escape codes",
        table(lambda n: f"{33 * n},7", "timestamp,turntable_deg,\x1b[31mred\x07\n"),
        EITHER,
        (),
    )
    yield "a cell of 200 kB", (head + f'{stamps[0]},"{"x" * 200_000}"\n').encode(), REFUSED, users
    for column, raw in (
        ("distance_m", "-1"),
        ("distance_m", "1e300"),
        ("temperature_c", "-500"),
        ("shutter_s", "1e300"),
        ("ambient_lux", "-5"),
        ("shutter_s", "-1"),
    ):
        yield f"{column} {raw}", table(lambda n, raw=raw: raw, f"timestamp,{column}\n"), EITHER, ()
    for name, content in encodings(table(lambda n: 33 * n)):
        yield (
            name,
            content,
            {"BOM": ACCEPTED, "CRLF": ACCEPTED, "Latin-1": REFUSED, "surrogates": REFUSED}.get(name, EITHER),
            ("convert",),
        )


def write(name: str, content: bytes) -> Edit:
    return lambda rec: (rec / name).write_bytes(content)


def cases() -> Iterator[Case]:
    here = ("groundtruth.txt", "--poses")
    stated = [
        Break(
            name,
            write("groundtruth.txt", content),
            expected,
            here,
            ("stated",) if expected is REFUSED else ("convert",),
            quick=name in ("nan", "BOM"),
        )
        for name, content, expected in poses()
    ]
    odd = [
        Break(
            f"is {name}",
            lambda rec, put=put: put(rec / "groundtruth.txt"),
            REFUSED,
            (*here, "poses"),
            ("stated",),
            quick=name == "a FIFO",
        )
        for name, put in NO_FILE.items()
    ]  # type: ignore[misc]
    yield from crossed("groundtruth.txt", [*stated, *odd], POSE_READERS)
    for name, content, expected in poses():
        yield from over_file("--poses", f"{name} poses.txt", content, OPTION, expected=expected)
    for name, put in NO_FILE.items():
        yield from over_file("--poses is", f"{name} poses.txt", put, OPTION, expected=REFUSED)
    log = ("telemetry", "turntable_deg", "log ")
    tables = [
        Break(
            name,
            write("telemetry.csv", content or b""),
            expected,
            log,
            sure if expected is ACCEPTED else ("none",),
            sure if expected is REFUSED else (),
            of="turntable",
            quick=name in ("one angle 1e300", "BOM", "a column with escape codes"),
        )
        for name, content, expected, sure in telemetry()
    ]
    yield from crossed("telemetry.csv", tables, ("info", "turntable", "convert"))
    radians = Break(
        "in radians, told",
        write("telemetry.csv", next(c for n, c, _, _ in telemetry() if n == "in radians") or b""),
        REFUSED,
        ("radian",),
        told=("info", "turntable"),
        of="turntable",
    )
    yield from crossed("telemetry.csv", [radians], ("info", "turntable"))
    odd = [
        Break(
            f"is {name}",
            lambda rec, put=put: put(rec / "telemetry.csv"),
            REFUSED,
            log,
            ("none",),
            ("turntable", "convert") if name != "no file" else (),
            of="turntable",
        )
        for name, put in NO_FILE.items()
    ]  # type: ignore[misc]
    yield from crossed("telemetry.csv", odd, ("info", "turntable", "convert"))
