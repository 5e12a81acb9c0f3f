"""Words on the command line: numbers, names, paths, commands."""

from collections.abc import Iterator
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
    "convert --triangles": (["convert", "good.ply", "out.ply", "--triangles"], ("1_0", "\u0663")),
    "convert --smooth": (["convert", "good.ply", "out.ply", "--smooth"], ("0", "1_0", "\u0663")),
    "repeat --diameter": (["repeat", "good.ply", "moved.ply", *SCAN, "--diameter"], ()),
    "simulate --seed": (
        ["simulate", "wall", "-o", "out", "--set", "frames=1", "--camera", "camera.json", "--seed"],
        ("0", "1_0", "\u0663"),
    ),
    "intrinsics --distance": (
        ["calibrate", "intrinsics", "checkerboard", "--board", "board.json", *SCAN, "--distance"],
        (),
    ),
    "depth --distance-std": (["calibrate", "depth", "wall", *SCAN, "--distance-std"], ("0", "1e-300")),
    "depth --radial-limit": (["calibrate", "depth", "wall", *SCAN, "--radial-limit"], ("inf", "1e300")),
    "evaluate --distance-std": (["evaluate", "wall", *SCAN, "--distance-std"], ("0", "1e-300")),
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


def option_case(
    name: str, words: list[str], expected: Expected, where: tuple[str, ...], quick: bool = False, weight: int = 1
) -> Case:
    def make(folder: Path) -> list[str]:
        outside(folder)
        bases.beside(folder, words)
        return words

    out = "out.ply" if "out.ply" in words else "out"
    title = f"option: {name}: {words[0] if words else 'nothing'}"
    return Case(title, make, expected, where, out, quick=quick, weight=weight)


def shown(value: str) -> str:
    """For a case's name."""
    return ascii(value)[1:-1] if len(value) < 40 else f"{len(value)} letters"


def numbers() -> Iterator[Case]:
    for name, (words, fine) in NUMERIC.items():
        option = words[-1]
        for value in NUMBERS:
            right = value in fine or value in READABLE
            yield option_case(
                f"{name} {shown(value)}",
                [*words, value],
                EITHER if right else REFUSED,
                (option,),
                (name, value) in (("reconstruct --voxel", "0"), ("reconstruct --voxel", "nan")),
                3,
            )
    for value in ("90", "-400", "400", "180", "1e-9"):
        yield option_case(
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
            yield option_case(
                f"{command} --box {value}",
                [command, of, *SCAN, "--voxel", "0.02", "--box", *six],
                REFUSED,
                ("--box",),
                (command, value) == ("turntable", "nan"),
            )
    yield option_case(
        "turntable --box turned",
        ["turntable", "turntable", *SCAN, "--box", "1", "1", "1", "0", "0", "0"],
        REFUSED,
        ("--box",),
    )
    yield option_case(
        "turntable --box huge",
        ["turntable", "turntable", *SCAN, "--voxel", "0.008", "--box", *["-1e30"] * 3, *["1e30"] * 3],
        EITHER,
        ("--box",),
        weight=4,
    )
    yield option_case(
        "turntable --box five", ["turntable", "turntable", *SCAN, "--box", "0", "0", "0", "1", "1"], REFUSED, ("--box",)
    )
    for pixel in (("nan", "1"), ("-1", "-1"), ("160", "0"), ("1e300", "0"), ("1.5", "2"), ("9" * 400, "0")):
        yield option_case(
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
                yield option_case(
                    f"{scene} --set {name}={shown(value)}",
                    words,
                    EITHER if fine else REFUSED,
                    (name,),
                    (name, value) == ("turns", "nan"),
                    2,
                )
    for frames in ("0", "1000000000", "2.5"):
        yield option_case(
            f"wall --set frames={frames}",
            ["simulate", "wall", "--camera", "camera.json", "-o", "out", "--set", f"frames={frames}"],
            REFUSED,
            ("frames", "--allow-gb"),
        )
    for text in ("frames", "=5", "nonsense=5", "frames=1=2", "", LETTERS + "=1", "x" * 5000 + "=1", "\udcff=1"):
        yield option_case(
            f"wall --set {shown(text)}",
            ["simulate", "wall", "-o", "out", "--camera", "camera.json", "--set", text],
            REFUSED,
            ("--set", "frames", "nonsense", "red", "xxx", "udcff", "setting"),
        )
    yield option_case(
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
        yield option_case(f"turntable --set mesh={shown(mesh)}", words, REFUSED, (mesh[:20], "mesh"))


def cases() -> Iterator[Case]:
    yield from numbers()
    yield from settings()
