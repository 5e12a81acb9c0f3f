"""One broken input crossed with every command that takes it."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from broken import bases
from broken.case import EITHER, REFUSED, TOLD, Case, Expected, Look

Edit = Callable[[Path], object]  # breaks something in a good recording's folder, or writes a broken file to a path

# words after `fusion`; REC the recording. Without reports and with coarse voxels: what is judged is the reading
OVER_RECORDING = {
    "info": ["info", "REC"],
    "convert": ["convert", "REC", "out"],
    "reconstruct": ["reconstruct", "REC", "-o", "out", "--no-report", "--voxel", "0.02"],
    "stated": ["reconstruct", "REC", "-o", "out", "--no-report", "--voxel", "0.02", "--poses", "stated"],
    "turntable": ["turntable", "REC", "-o", "out", "--no-report", "--voxel", "0.008"],
    "evaluate": ["evaluate", "REC", "-o", "out", "--no-report"],
    "depth": ["calibrate", "depth", "REC", "-o", "out", "--no-report"],
    "noise": ["calibrate", "noise", "REC", "-o", "out", "--no-report"],
    "explain": ["explain", "REC", "--sensor", "kinect-v1", "-o", "out"],
    "simulate": ["simulate", "REC", "-o", "out"],
    "ideal": ["simulate", "--ideal", "REC", "-o", "out", "--sensor", "kinect-v1"],
    "intrinsics": ["calibrate", "intrinsics", "REC", "--board", "board.json", "-o", "out", "--no-report"],
}
HEAVY = {
    "reconstruct": 3,
    "stated": 2,
    "turntable": 8,
    "explain": 6,
    "evaluate": 2,
    "depth": 2,
    "simulate": 2,
}  # seconds of a whole run
SKIPPING = ("info", "reconstruct", "turntable", "evaluate", "depth", "noise", "explain")  # may do without a frame
DEPTH_READERS = ("info", "convert", "ideal", "reconstruct", "turntable", "evaluate", "depth", "noise", "explain")


@dataclass(frozen=True)
class Break:
    """One way in which a recording can be broken.

    `sure`: the commands whose answer is `expected`, all where none is named; `told`: those that may leave the broken
    part out where they say so; the others may do either. `where`: see `Case`.
    """

    name: str
    edit: Edit
    expected: Expected = EITHER
    where: tuple[str, ...] = ()
    sure: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    of: str = "wall"
    look: Look | None = None
    quick: bool = False


def crossed(theme: str, breaks: Iterable[Break], commands: tuple[str, ...]) -> Iterator[Case]:
    """A case for each break and each of the commands; the first command is the one of the quick part."""
    for broken in breaks:
        for number, command in enumerate(commands):
            expected = _expected(broken, command)
            yield Case(
                name=f"{theme}: {broken.name}: {command}",
                make=_maker(broken, command),
                expected=expected,
                where=broken.where if expected in (REFUSED, TOLD) else (),
                look=broken.look,
                quick=broken.quick and number == 0,
                weight=1 if expected is REFUSED else HEAVY.get(command, 1),  # refusing is quick
            )


def _expected(broken: Break, command: str) -> Expected:
    if (not broken.sure and not broken.told) or command in broken.sure:
        return broken.expected
    return TOLD if command in broken.told and broken.expected is REFUSED else EITHER


def _maker(broken: Break, command: str) -> Callable[[Path], list[str]]:
    words = OVER_RECORDING[command]

    def make(folder: Path) -> list[str]:
        rec = bases.recording(folder, of="turntable" if command == "turntable" else broken.of)
        outside(folder)
        if "board.json" in words:
            bases.write_json(folder / "board.json", bases.BOARD)
        broken.edit(rec)
        return ["rec" if word == "REC" else word for word in words]

    return make


def outside(folder: Path) -> Path:
    """A folder beside the recording whose content no command has any business with."""
    place = folder / "outside"
    place.mkdir()
    for name in ("camera.json", "mesh.ply", "depth.png", "board.json", "values.npy", "poses.txt", "telemetry.csv"):
        (place / name).write_text("OUTSIDE-SECRET\n", encoding="ascii")
    for name in ("depth", "scene.ply"):
        source = bases.place() / "wall" / name
        target = place / ("good_" + name)
        target.write_bytes((source / "000000.png" if source.is_dir() else source).read_bytes())
    return place


def over_file(
    theme: str,
    name: str,
    content: bytes | Edit,
    runs: dict[str, list[str]],
    expected: Expected = EITHER,
    out: str = "out",
    look: Look | None = None,
) -> Iterator[Case]:
    """A broken single file, crossed with command lines in which FILE stands for it; its name ends with the file's."""
    ending = name.rsplit(" ", 1)[-1]
    file = f"broken.{ending.rsplit('.', 1)[-1]}"
    for command, words in runs.items():

        def make(folder: Path, words: list[str] = words) -> list[str]:
            outside(folder)
            bases.beside(folder, words)
            path = folder / file
            if callable(content):
                content(path)
            else:
                path.write_bytes(content)
            return [word.replace("FILE", file) for word in words]

        options = tuple(word for word in words if word.startswith("--"))
        where = (file, *options) if expected in (REFUSED, TOLD) else ()  # others may be refused for what lies elsewhere
        yield Case(f"{theme}: {name}: {command}", make, expected, where, out, look, weight=HEAVY.get(command, 1))
