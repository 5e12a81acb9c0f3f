"""Words on the command line: numbers, names, paths, commands."""

from collections.abc import Callable, Iterator
from pathlib import Path

from broken import bases
from broken.case import EITHER, REFUSED, Case, Expected
from broken.crossing import outside

LETTERS = "\x1b[31mred\x07\u202egnp"
NUMBERS = (
    "0",
    "nan",
    "inf",
    "-inf",
    "-1",
    "1e300",
    "1e-300",
    "",
    "9" * 400,
    "many",
    "1,5",
    "0x10",
    "1_0",
    "\u0663",
    " ",
    LETTERS,
    "x" * 5000,
    "\udcff",
)
SCAN = ["-o", "out", "--no-report"]
# each option that takes a number: the words before it, and those values that may be right
NUMERIC: dict[str, tuple[list[str], tuple[str, ...]]] = {
    "reconstruct --voxel": (["reconstruct", "wall", *SCAN, "--voxel"], ()),
    "reconstruct --truncation": (["reconstruct", "wall", *SCAN, "--voxel", "0.02", "--truncation"], ()),
    "reconstruct --max-depth": (["reconstruct", "wall", *SCAN, "--voxel", "0.02", "--max-depth"], ("inf", "1e300")),
    "turntable --voxel": (["turntable", "turntable", *SCAN, "--voxel"], ()),
    "turntable --step": (["turntable", "turntable", *SCAN, "--voxel", "0.008", "--step"], ("-1",)),
    "compare --max-distance": (["compare", "good.ply", "good.ply", *SCAN, "--max-distance"], ("inf", "1e300")),
    "simulate --seed": (
        ["simulate", "wall", "-o", "out", "--set", "frames=1", "--camera", "camera.json", "--seed"],
        ("0", "1_0", "\u0663"),
    ),
    "intrinsics --distance": (
        ["calibrate", "intrinsics", "checkerboard", "--board", "board.json", *SCAN, "--distance"],
        (),
    ),
    "depth --distance-std": (["calibrate", "depth", "wall", *SCAN, "--distance-std"], ("0",)),
    "depth --radial-limit": (["calibrate", "depth", "wall", *SCAN, "--radial-limit"], ("inf", "1e300")),
    "evaluate --distance-std": (["evaluate", "wall", *SCAN, "--distance-std"], ("0",)),
    "demo --frames": (["demo", "-o", "out", "--no-report", "--frames"], ()),
    "simulate --allow-gb": (
        ["simulate", "wall", "-o", "out", "--set", "frames=1", "--camera", "camera.json", "--allow-gb"],
        ("inf", "1e300", "1e-300"),
    ),
    "info --allow-gb": (["info", "wall", "--allow-gb"], ("inf", "1e300", "1e-300")),
}
READABLE = ("1_0", "\u0663", " ")  # float() takes them, and what it makes of them is what a person meant
SETTINGS = {
    "wall": ("distance_m", "tilt_deg", "reflectance", "frames", "ambient_lux", "sigma_m", "sigma_rad"),
    "turntable": (
        "scale",
        "turns",
        "frames",
        "elevation_deg",
        "distance_m",
        "uneven_sd_deg",
        "slip_frame",
        "slip_deg",
        "wobble_deg",
        "continuous",
        "mesh",
    ),
}


def _case(
    name: str, words: list[str], expected: Expected, where: tuple[str, ...], quick: bool = False, weight: int = 1
) -> Case:
    def make(folder: Path) -> list[str]:
        outside(folder)
        bases.beside(folder, words)
        return words

    return Case(
        f"option: {name}: {words[0] if words else 'nothing'}", make, expected, where, quick=quick, weight=weight
    )


def shown(value: str) -> str:
    """For a case's name."""
    return ascii(value)[1:-1] if len(value) < 40 else f"{len(value)} letters"


def numbers() -> Iterator[Case]:
    for name, (words, fine) in NUMERIC.items():
        option = words[-1]
        for value in NUMBERS:
            right = value in fine or value in READABLE
            yield _case(
                f"{name} {shown(value)}",
                [*words, value],
                EITHER if right else REFUSED,
                (option,),
                (name, value) in (("reconstruct --voxel", "0"), ("reconstruct --voxel", "nan")),
                3,
            )
    for value in ("90", "-400", "400", "180", "1e-9"):
        yield _case(
            f"turntable --step {value}",
            [*NUMERIC["turntable --step"][0], value],
            EITHER,
            ("--step", "turntable"),
            weight=4,
        )
    for value in ("nan", "inf", "1e300", "many", "-1", "0"):
        six = [value] * 6
        for command in ("reconstruct", "turntable"):
            of = "wall" if command == "reconstruct" else "turntable"
            yield _case(
                f"{command} --box {value}",
                [command, of, *SCAN, "--voxel", "0.02", "--box", *six],
                REFUSED,
                ("--box",),
                (command, value) == ("turntable", "nan"),
            )
    yield _case(
        "turntable --box turned",
        ["turntable", "turntable", *SCAN, "--box", "1", "1", "1", "0", "0", "0"],
        REFUSED,
        ("--box",),
    )
    yield _case(
        "turntable --box huge",
        ["turntable", "turntable", *SCAN, "--voxel", "0.008", "--box", *["-1e30"] * 3, *["1e30"] * 3],
        EITHER,
        ("--box",),
        weight=4,
    )
    yield _case(
        "turntable --box five", ["turntable", "turntable", *SCAN, "--box", "0", "0", "0", "1", "1"], REFUSED, ("--box",)
    )
    for pixel in (("nan", "1"), ("-1", "-1"), ("160", "0"), ("1e300", "0"), ("1.5", "2"), ("9" * 400, "0")):
        yield _case(
            f"evaluate --pixel {shown(' '.join(pixel))}",
            ["evaluate", "wall", *SCAN, "--pixel", *pixel],
            REFUSED if pixel[0] != "1.5" else EITHER,
            ("--pixel", "pixel"),
        )


def settings() -> Iterator[Case]:
    base = {"wall": ["frames=1"], "turntable": ["frames=4"]}
    for scene, names in SETTINGS.items():
        for name in names:
            for value in ("nan", "inf", "-1", "1e300", "", "many", "9" * 400, LETTERS):
                words = [
                    "simulate",
                    scene,
                    "--camera",
                    "camera.json",
                    "-o",
                    "out",
                    *(w for s in base[scene] for w in ("--set", s)),
                    "--set",
                    f"{name}={value}",
                ]
                fine = (name, value) in (
                    ("distance_m", "many"),
                    ("tilt_deg", "-1"),
                    ("turns", "-1"),
                    ("elevation_deg", "-1"),
                    ("slip_deg", "-1"),
                    ("wobble_deg", "-1"),
                    ("mesh", ""),
                ) or (name == "slip_frame" and value == "-1")
                yield _case(
                    f"{scene} --set {name}={shown(value)}",
                    words,
                    EITHER if fine else REFUSED,
                    (name,),
                    (name, value) == ("turns", "nan"),
                    2,
                )
    for frames in ("0", "1000000000", "2.5"):
        yield _case(
            f"wall --set frames={frames}",
            ["simulate", "wall", "--camera", "camera.json", "-o", "out", "--set", f"frames={frames}"],
            REFUSED,
            ("frames", "--allow-gb"),
        )
    for text in ("frames", "=5", "nonsense=5", "frames=1=2", "", LETTERS + "=1", "x" * 5000 + "=1", "\udcff=1"):
        yield _case(
            f"wall --set {shown(text)}",
            ["simulate", "wall", "-o", "out", "--camera", "camera.json", "--set", text],
            REFUSED,
            ("--set", "frames", "nonsense", "red", "xxx", "udcff", "setting"),
        )
    yield _case(
        "wall --set 1000 distances",
        [
            "simulate",
            "wall",
            "-o",
            "out",
            "--camera",
            "camera.json",
            "--set",
            "frames=1",
            "--set",
            "distance_m=" + ",".join(["1"] * 300),
        ],
        EITHER,
        ("distance_m",),
    )
    for mesh in ("/etc/passwd", "/dev/zero", "missing.ply", "outside", "x" * 5000):
        words = [
            "simulate",
            "turntable",
            "-o",
            "out",
            "--camera",
            "camera.json",
            "--set",
            "frames=2",
            "--set",
            f"mesh={mesh}",
        ]
        yield _case(f"turntable --set mesh={shown(mesh)}", words, REFUSED, (mesh[:20], "mesh"))


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
            yield _case(
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
        yield _case(
            f"usage, {name}",
            words,
            EITHER if name == "no command" else REFUSED,
            (),
            name in ("command with escape codes", "option no UTF-8", "the same recording twice"),
            2,
        )


def cases() -> Iterator[Case]:
    yield from numbers()
    yield from settings()
    yield from paths()
    yield from wrong_usage()
