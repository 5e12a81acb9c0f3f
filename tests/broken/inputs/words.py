"""Paths and commands on the command line."""

from collections.abc import Callable, Iterator

from broken.case import EITHER, REFUSED, Case
from broken.inputs.options import LETTERS, SCAN, option_case

PATHS = {
    "info REC": ["info", "PATH"],
    "info --camera": ["info", "wall", "--camera", "PATH"],
    "convert IN": ["convert", "PATH", "out"],
    "sensor show": ["sensor", "show", "PATH"],
    "simulate SCENE": ["simulate", "PATH", "-o", "out"],
    "simulate --sensor": ["simulate", "wall", "-o", "out", "--camera", "camera.json", "--sensor", "PATH"],
    "reconstruct --poses": ["reconstruct", "wall", *SCAN, "--voxel", "0.02", "--poses", "PATH"],
    "reconstruct --sensor": ["reconstruct", "wall", *SCAN, "--voxel", "0.02", "--sensor", "PATH"],
    "turntable --mask": ["turntable", "turntable", *SCAN, "--voxel", "0.008", "--mask", "PATH"],
    "compare MESH": ["compare", "PATH", "good.ply", *SCAN],
    "compare REFERENCE": ["compare", "good.ply", "PATH", *SCAN],
    "repeat SCAN": ["repeat", "PATH", "good.ply", *SCAN],
    "compare --seen": ["compare", "good.ply", "good.ply", *SCAN, "--seen", "PATH"],
    "intrinsics --board": ["calibrate", "intrinsics", "checkerboard", *SCAN, "--board", "PATH"],
    "depth --camera": ["calibrate", "depth", "wall", *SCAN, "--camera", "PATH"],
    "evaluate REC": ["evaluate", "wall", "PATH", *SCAN],
    "explain --sensor": ["explain", "wall", "-o", "out", "--sensor", "PATH"],
    "explain --simulated": ["explain", "wall", "-o", "out", "--sensor", "kinect-v1", "--simulated", "PATH"],
    "noise REC": ["calibrate", "noise", "PATH", *SCAN],
}


THINGS: dict[str, Callable[[], str]] = {
    "empty": lambda: "",
    "missing": lambda: "missing.json",
    "a folder": lambda: "outside",
    "5 kB": lambda: "x" * 5000,
    "escape codes": lambda: LETTERS,
    "no UTF-8": lambda: "\udcff\udcfe",
    "a new line": lambda: "a\nb",
    "/dev/zero": lambda: "/dev/zero",
    "/dev/null": lambda: "/dev/null",
    "/etc/passwd": lambda: "/etc/passwd",
    "below a file": lambda: "/etc/passwd/x.json",
    "a web address": lambda: "http://127.0.0.1:9/x.json",
    "/proc/self/mem": lambda: "/proc/self/mem",
    "a dash": lambda: "-",
}


def paths() -> Iterator[Case]:
    for name, words in PATHS.items():
        for thing, value in THINGS.items():
            word = value()
            marks = (
                ascii(word)[1:-1][:15],
                word[:15] or "''",
                words[-1],
                *(w for w in words if w.startswith("--")),
                words[0],
                *((r"a\nb", "a?b", "a\ufffdb") if "\n" in word else ()),
                "red",
                "udcff",
                "xff",
            )
            yield option_case(
                f"{name} {thing}",
                [word if w == "PATH" else w for w in words],
                REFUSED,
                tuple(m for m in marks if m),
                (name, thing) in (("info REC", "escape codes"), ("sensor show", "/dev/zero"), ("info REC", "no UTF-8")),
                2,
            )


def wrong_usage() -> Iterator[Case]:
    lines = {
        "no command": [],
        "unknown command": ["magic"],
        "command with escape codes": [LETTERS],
        "command of 5 kB": ["x" * 5000],
        "command no UTF-8": ["\udcff"],
        "empty command": [""],
        "unknown option": ["info", "wall", "--magic"],
        "option with escape codes": ["info", "wall", "--" + LETTERS],
        "option of 5 kB": ["info", "wall", "--" + "x" * 5000],
        "option no UTF-8": ["info", "wall", "--\udcff"],
        "no recording": ["info"],
        "two recordings": ["info", "wall", "wall"],
        "no output": ["reconstruct", "wall"],
        "unknown unit": ["compare", "a.ply", "b.ply", "-o", "out", "--unit", "furlong"],
        "unknown device": ["reconstruct", "wall", "-o", "out", "--device", LETTERS],
        "unknown strength": ["turntable", "turntable", "-o", "out", "--strength", "x" * 5000],
        "room and object": ["reconstruct", "wall", "-o", "out", "--room", "--object"],
        "unknown shell": ["completion", "tcsh"],
        "shell with escape codes": ["completion", LETTERS],
        "shell of 5 kB": ["completion", "x" * 5000],
        "sensor magic": ["sensor", "magic"],
        "calibrate magic": ["calibrate", "magic", "wall"],
        "unknown preset": ["sensor", "show", "kinect-v9"],
        "preset with a path": ["sensor", "show", "../kinect-v1"],
        "show without a name": ["sensor", "show"],
        "unknown scene": ["simulate", "moon", "-o", "out"],
        "unknown camera": ["info", "wall", "--camera", "leica"],
        "10,000 recordings": ["evaluate", *["missing"] * 10_000, "-o", "out"],
        "the same recording twice": ["explain", "wall", "wall", "--sensor", "kinect-v1", "-o", "out"],
        "more simulated than recorded": [
            "explain",
            "wall",
            "--simulated",
            "wall",
            "wall",
            "--sensor",
            "kinect-v1",
            "-o",
            "out",
        ],
        "a number for a name": ["explain", "5", "--sensor", "5", "-o", "out"],
        "simulate without output": ["simulate", "wall"],
        "keep and refine": ["turntable", "turntable", "-o", "out", "--keep-camera", "--refine-camera"],
    }
    for name, words in lines.items():
        yield option_case(
            f"usage, {name}",
            words,
            EITHER if name == "no command" else REFUSED,
            (),
            name in ("command with escape codes", "option no UTF-8", "the same recording twice"),
            2,
        )


def cases() -> Iterator[Case]:
    yield from paths()
    yield from wrong_usage()
