"""Where a result goes: what is there already, what is no place, and names that are hard to write."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from broken import bases
from broken.case import ACCEPTED, EITHER, REFUSED, Case
from broken.odd_files import fifo, link

LETTERS = "\x1b[31mred\x07"
# a result that another run of the same command left is made by the command itself: see `_earlier`
COMMANDS = {
    "convert": ["convert", "wall", "OUT"],
    "simulate": ["simulate", "scene.json", "-o", "OUT"],
    "evaluate": ["evaluate", "wall", "-o", "OUT", "--no-report"],
    "depth": ["calibrate", "depth", "wall", "-o", "OUT", "--no-report"],
    "noise": ["calibrate", "noise", "wall", "-o", "OUT", "--no-report"],
    "intrinsics": ["calibrate", "intrinsics", "checkerboard", "--board", "board.json", "-o", "OUT", "--no-report"],
    "compare": ["compare", "good.ply", "good.ply", "-o", "OUT", "--no-report"],
    "repeat": ["repeat", "good.ply", "moved.ply", "-o", "OUT", "--no-report"],
    "reconstruct": ["reconstruct", "wall", "-o", "OUT", "--no-report", "--voxel", "0.02"],
    "turntable": ["turntable", "turntable", "-o", "OUT", "--no-report", "--voxel", "0.008"],
    "explain": ["explain", "wall", "--sensor", "kinect-v1", "-o", "OUT"],
    "demo": ["demo", "-o", "OUT", "--no-report", "--frames", "12"],
}
ROOT = os.geteuid() == 0  # whose mistakes reach the machine's own files: a program under test may not make them
LIGHT = ("convert", "simulate", "evaluate")
Put = Callable[[Path], object]


def _file(path: Path) -> None:
    path.write_text("a letter\n", encoding="ascii")


def _strangers(path: Path) -> None:
    (path / "deep").mkdir(parents=True)
    (path / "letter.txt").write_text("dear reader\n", encoding="ascii")
    (path / "deep" / "mesh.ply").write_text("mine\n", encoding="ascii")


def _a_recording(path: Path) -> None:
    bases.recording(path.parent, path.name)


def _other_result(path: Path) -> None:
    """What another command's result looks like, by the marker that results carry."""
    path.mkdir()
    (path / "another.json").write_text("{}", encoding="ascii")
    marker = {"command": "another", "fusion": "0.1.0", "files": ["another.json"]}
    bases.write_json(path / ".fusion.json", marker)


def _false_marker(command: str) -> Put:
    """Strangers beside a marker that calls the folder a result of the command; its list reaches out."""
    name = {"depth": "calibrate depth", "noise": "calibrate noise", "intrinsics": "calibrate intrinsics"}.get(
        command, command
    )

    def put(path: Path) -> None:
        _strangers(path)
        told = {"command": name, "fusion": "0.1.0", "files": ["../wall/depth.txt", "../good.ply", "/etc/passwd"]}
        bases.write_json(path / ".fusion.json", told)

    return put


def _strangers_kept(folder: Path, printed: str) -> str:
    """What the command did not make is still there."""
    kept = (folder / "out" / "letter.txt").is_file() and (folder / "out" / "deep" / "mesh.ply").is_file()
    return "" if kept else "files of somebody else are gone"


def _broken_marker(path: Path) -> None:
    _strangers(path)
    (path / ".fusion.json").write_bytes(b"[" * 100_000)


def _marker_is_fifo(path: Path) -> None:
    _strangers(path)
    fifo(path / ".fusion.json")


def _link_to_strangers(path: Path) -> None:
    _strangers(path.parent / "elsewhere")
    path.symlink_to("elsewhere")


OCCUPIED: dict[str, Put] = {
    "a file": _file,
    "strangers": _strangers,
    "a recording": _a_recording,
    "another command's result": _other_result,
    "a broken marker": _broken_marker,
    "a marker that is a FIFO": _marker_is_fifo,
    "a FIFO": fifo,
    "a link to nothing": link("nowhere/deep"),
    "a link in a loop": link("out"),
    "a link to strangers": _link_to_strangers,
}

if not ROOT:
    OCCUPIED["a link to /dev/null"] = link("/dev/null")


def _make(words: list[str], out: str, put: Put | None = None) -> Callable[[Path], list[str]]:
    def make(folder: Path) -> list[str]:
        bases.beside(folder, [*words, "lump.ply"])
        if put is not None:
            put(folder / out)
        return [out if word == "OUT" else word for word in words]

    return make


def occupied() -> Iterator[Case]:
    for command, words in COMMANDS.items():
        for name, put in OCCUPIED.items():
            for more in ([], ["--overwrite"]):
                text = f"place: over {name}{' --overwrite' if more else ''}: {command}"
                yield Case(
                    text,
                    _make([*words, *more], "out", put),
                    EITHER if name == "a link to nothing" else REFUSED,  # a place that the user chose and linked
                    () if name == "a link to nothing" else ("out",),
                    quick=command in ("convert", "simulate") and name in ("strangers", "a recording"),
                )
        marked = _make([*words, "--overwrite"], "out", _false_marker(command))
        text = f"place: over a false marker --overwrite: {command}"
        yield Case(text, marked, EITHER, look=_strangers_kept, weight=6, quick=command == "convert")
        yield Case(
            f"place: into an empty folder: {command}",
            _make(words, "out", lambda path: path.mkdir()),
            EITHER if command in ("noise", "intrinsics", "explain", "demo", "depth") else ACCEPTED,
            ("out", "wall", "checkerboard"),
            weight=6,
        )


def names() -> Iterator[Case]:
    places = {
        "here": ".",
        "above": "..",
        "empty": "",
        "below a file": "camera.json/out",
        "300 letters": "x" * 300,
        "5 kB": "x" * 5000,
        "deep path": "a/" * 1500 + "x",
        "below a link in a loop": "loop/out",
        "/proc/x": "/proc/x",
    }
    if not ROOT:
        places |= {"the root": "/", "/dev/null": "/dev/null", "/dev/full": "/dev/full"}
    for command, words in COMMANDS.items():
        for name, place in places.items():

            def make(folder: Path, words: list[str] = words, place: str = place) -> list[str]:
                bases.beside(folder, [*words, "lump.ply", "camera.json"])
                (folder / "loop").symlink_to("loop")
                return [place if word == "OUT" else word for word in words]

            yield Case(
                f"place: to {name}: {command}",
                make,
                REFUSED,
                tuple(w for w in (place[:30], "'.'", "-o", "--output", "OUT", "output", "folder") if w),
                out="none",
                quick=command == "convert" and name in ("below a file", "5 kB"),
            )
    for command in LIGHT:
        for name, place in {
            "escape codes": LETTERS,
            "a new line": "a\nb",
            "no UTF-8": "\udcff",
            "spaces": " a b ",
            "a dash": "--",
            "a missing parent": "new/deep/out",
            "turned writing": "\u202egnp",
            "a dot file": ".out",
            "ends with /": "out/",
        }.items():
            words = COMMANDS[command]
            known = place if place != "new/deep/out" else "new"

            def make(folder: Path, words: list[str] = words, place: str = place) -> list[str]:
                bases.beside(folder, [*words, "lump.ply"])
                return [place if word == "OUT" else word for word in words]

            yield Case(f"place: named {name}: {command}", make, EITHER, (), out=known.rstrip("/"), weight=2)


def _input_of(words: list[str]) -> str:
    return next(word for word in words if word in ("wall", "turntable", "checkerboard", "good.ply", "scene.json"))


def inputs() -> Iterator[Case]:
    """The result in, over or around what is read."""
    for command, words in COMMANDS.items():
        if command == "demo":
            continue
        given = _input_of(words)
        over = {
            "the input": given,
            "inside the input": f"{given}/out",
            "a folder of the input": f"{given}/depth",
            "the input by another way": f"{given}/../{given}",
            "around the input": ".",
        }
        if given in ("good.ply", "scene.json"):
            over = {"the input": given, "around the input": "."}
        for name, place in over.items():
            for more in ([], ["--overwrite"]):
                yield Case(
                    f"place: to {name}{' --overwrite' if more else ''}: {command}",
                    _make([*[place if w == "OUT" else w for w in words], *more], "out"),
                    REFUSED,
                    (given, "."),
                    out="none",
                    quick=command == "intrinsics" and name == "the input",
                )
        if given not in ("good.ply", "scene.json"):

            def make(folder: Path, words: list[str] = words, given: str = given) -> list[str]:
                bases.beside(folder, [*words, "lump.ply"])
                (folder / "alias").symlink_to(given)
                return ["alias" if word == "OUT" else word for word in words] + ["--overwrite"]

            yield Case(f"place: to a link to the input: {command}", make, REFUSED, ("alias", given), out="none")


def _around(kind: str) -> Callable[[Path], list[str]]:
    def make(folder: Path) -> list[str]:
        bases.beside(folder, ["compare", "good.ply"])
        target = folder / "out"
        target.mkdir()
        if kind == "mesh":
            shutil.move(folder / "good.ply", target / "mesh.ply")
            bases.write_json(target / ".fusion.json", {"command": "compare", "fusion": "0.1.0", "files": ["mesh.ply"]})
            return ["compare", "out/mesh.ply", "out/mesh.ply", "-o", "out", "--no-report", "--overwrite"]
        if kind == "sensor":
            bases.recording(folder, "wall")
            bases.write_json(target / "sensor.json", bases.sensor())
            bases.write_json(
                target / ".fusion.json", {"command": "evaluate", "fusion": "0.1.0", "files": ["sensor.json"]}
            )
            return ["evaluate", "wall", "--sensor", "out/sensor.json", "-o", "out", "--no-report", "--overwrite"]
        bases.recording(target, "wall")
        bases.write_json(target / ".fusion.json", {"command": "evaluate", "fusion": "0.1.0", "files": []})
        return ["evaluate", "out/wall", "-o", "out", "--no-report", "--overwrite"]

    return make


def particular() -> Iterator[Case]:
    """The lines of people who lost something."""
    for kind in ("mesh", "sensor", "recording"):
        yield Case(
            f"place: an earlier result that holds the {kind} that is read: overwrite",
            _around(kind),
            REFUSED,
            ("out",),
            out="none",
            quick=kind == "mesh",
        )

    def copied(folder: Path) -> list[str]:
        bases.recording(folder, "wall")
        shutil.copytree(folder / "wall", folder / "mine")
        return ["simulate", "wall/scene.json", "-o", "mine"]

    yield Case("place: over a copy of the recording: simulate", copied, REFUSED, ("mine",), out="none", quick=True)

    def ended(folder: Path, name: str) -> list[str]:
        bases.beside(folder, ["compare", "good.ply", "wall"])
        return ["convert", *name.split()]

    for line, expected in {
        "wall x.ply": REFUSED,
        "good.ply good.ply": REFUSED,
        "good.ply x.magic": REFUSED,
        "good.ply x": REFUSED,
        "good.ply wall": REFUSED,
        "wall wall": REFUSED,
        "good.ply good.ply --overwrite": REFUSED,
        "good.ply new/x.ply": EITHER,
        "good.ply x.PLY": EITHER,
        "good.ply wall/depth.txt": REFUSED,
        "good.ply .ply": EITHER,
        "wall wall/../x": ACCEPTED,
    }.items():
        out = {"wall wall/../x": "x", "good.ply new/x.ply": "new"}.get(
            line, line.split()[1] if expected is not REFUSED else "none"
        )
        yield Case(
            f"place: {line}: convert",
            lambda folder, line=line: ended(folder, line),
            expected,
            tuple(line.split()),
            out=out,
            quick=line == "wall x.ply",
        )  # type: ignore[misc]
    for name, put in {
        "a file": _file,
        "a folder": lambda path: path.mkdir(),
        "a FIFO": fifo,
        "a link to a file": _link_to_file,
        "a link to nothing": link("nowhere"),
    }.items():
        for more in ([], ["--overwrite"]):

            def over(folder: Path, put: Put = put, more: list[str] = more) -> list[str]:
                bases.beside(folder, ["compare", "good.ply"])
                put(folder / "x.ply")
                return ["convert", "good.ply", "x.ply", *more]

            # a file that this command may have made is replaced when it is said so
            yield Case(
                f"place: a mesh over {name}{' --overwrite' if more else ''}: convert",
                over,
                EITHER if more and "file" in name else REFUSED,
                ("x.ply",),
                out="x.ply",
            )
    yield Case("place: a folder without the right to write: convert", _unwritable, REFUSED, ("locked",), out="none")


def _link_to_file(path: Path) -> None:
    path.with_name("other.ply").write_text("mine\n", encoding="ascii")
    path.symlink_to("other.ply")


def _unwritable(folder: Path) -> list[str]:
    bases.recording(folder, "wall")
    (folder / "locked").mkdir(mode=0o500)
    return ["convert", "wall", "locked/out"]


def cases() -> Iterator[Case]:
    yield from occupied()
    yield from names()
    yield from inputs()
    yield from particular()
