"""Folders and files that are no recording, for every command that takes one."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from broken import bases, pictures
from broken.case import EITHER, REFUSED, Case
from broken.foreign import Build, open3d
from broken.inputs.foreign import RUNS
from broken.odd_files import fifo, link
from broken.odd_values import LETTERS


def nothing() -> Iterator[Case]:
    """Folders and files that are no recording, for every command that takes one."""

    def deep(rec: Path) -> None:
        rec.mkdir()
        place = rec
        for _ in range(200):
            place = place / "d"
            place.mkdir()

    def many(rec: Path) -> None:
        rec.mkdir()
        for n in range(3000):
            (rec / f"{n}.txt").touch()

    def file(content: bytes) -> Build:
        return lambda rec: rec.write_bytes(content)

    things: dict[str, Build] = {
        "an empty folder": lambda rec: rec.mkdir(),
        "a deep folder": deep,
        "3000 strange files": many,
        "a text": file(b"hello\n"),
        "an empty file": file(b""),
        "a PNG": file(pictures.png(np.zeros((4, 4), np.uint16))),
        "a mesh": file(b"ply\nformat ascii 1.0\n"),
        "a FIFO": fifo,
        "a link in a loop": link("rec"),
        "a link to /dev/zero": link("/dev/zero"),
        "strange names": lambda rec: (rec.mkdir(), (rec / LETTERS.replace("/", "")).touch(), (rec / "\udcff").touch()),
        "two formats in one": lambda rec: (
            open3d(rec),
            shutil.copytree(bases.place() / "wall", rec, dirs_exist_ok=True),
        ),
    }
    runs = {
        **RUNS,
        "turntable": ["turntable", "rec", "-o", "out"],
        "evaluate": ["evaluate", "rec", "-o", "out"],
        "depth": ["calibrate", "depth", "rec", "-o", "out"],
        "noise": ["calibrate", "noise", "rec", "-o", "out"],
        "explain": ["explain", "rec", "--sensor", "kinect-v1", "-o", "out"],
        "intrinsics": ["calibrate", "intrinsics", "rec", "--board", "board.json", "-o", "out"],
        "simulate": ["simulate", "rec", "-o", "out"],
    }
    for name, build in things.items():
        for run, words in runs.items():

            def make(place: Path, words: list[str] = words, build: Build = build) -> list[str]:
                bases.write_json(place / "board.json", bases.BOARD)
                build(place / "rec")
                return words

            yield Case(
                f"no recording: {name}: {run}",
                make,
                REFUSED if name != "two formats in one" else EITHER,
                ("rec",),
                quick=run == "info" and name in ("a FIFO", "strange names"),
            )


def cases() -> Iterator[Case]:
    yield from nothing()
