"""What is meant: links and folders of one's own, read where that is said; and what is no second evidence."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from broken import bases, foreign
from broken.case import ACCEPTED, REFUSED, Case
from broken.inputs.tables import line


def _linked(folder: Path) -> Path:
    """A recording whose first image lies in another folder of the same person."""
    rec = bases.recording(folder)
    (folder / "elsewhere").mkdir()
    shutil.move(rec / "depth" / "000000.png", folder / "elsewhere" / "first.png")
    (rec / "depth" / "000000.png").symlink_to("../../elsewhere/first.png")
    return rec


def _named(folder: Path) -> Path:
    rec = _linked(folder)
    line(0, "3600.0 ../elsewhere/first.png")(rec)
    return rec


def _images_elsewhere(folder: Path) -> Path:
    rec = bases.recording(folder)
    shutil.move(rec / "depth", folder / "elsewhere")
    (rec / "depth").symlink_to("../elsewhere")
    return rec


def _mesh_elsewhere(folder: Path) -> Path:
    rec = bases.recording(folder)
    (folder / "elsewhere").mkdir()
    shutil.move(rec / "scene.ply", folder / "elsewhere" / "scene.ply")
    (rec / "scene.ply").symlink_to("../elsewhere/scene.ply")
    return rec


LINKED: dict[str, Callable[[Path], Path]] = {
    "an image is a link": _linked,
    "an image is named elsewhere": _named,
    "the images are a link": _images_elsewhere,
    "the mesh is a link": _mesh_elsewhere,
}


def links() -> Iterator[Case]:
    """Refused as they are, read with the option."""
    for name, build in LINKED.items():
        for command, words in {
            "convert": ["convert", "rec", "out"],
            "simulate": ["simulate", "rec", "-o", "out"],
        }.items():
            if command == "simulate" and name != "the mesh is a link":
                continue  # which reads no image
            for more in ([], ["--follow-links"]):

                def make(
                    folder: Path, build: Callable = build, words: list[str] = words, more: list[str] = more
                ) -> list[str]:
                    build(folder)
                    return [*words, *more]

                expected, where = (ACCEPTED, ()) if more else (REFUSED, ("--follow-links",))
                text = f"lifted: {name}{' --follow-links' if more else ''}: {command}"
                yield Case(text, make, expected, where, quick=name == "an image is a link")


def _by_a_link(folder: Path) -> list[str]:
    bases.recording(folder)
    (folder / "alias").symlink_to("rec")
    return ["convert", "alias", "out"]


def _copied(folder: Path) -> list[str]:
    bases.recording(folder, "first")
    bases.recording(folder, "second")
    return ["explain", "first", "second", "--sensor", "kinect-v1", "-o", "out"]


def _table_as_mesh(folder: Path) -> list[str]:
    foreign.bop(folder / "rec")
    (folder / "rec" / "telemetry.csv").write_text("mine\n", encoding="ascii")
    bases.write_json(folder / "rec" / "scene.json", {"mesh": "telemetry.csv", "poses": {"source": "nominal"}})
    return ["convert", "rec", "out"]


def cases() -> Iterator[Case]:
    yield from links()
    yield Case("lifted: a recording by a link: convert", _by_a_link, ACCEPTED)
    yield Case("evidence: a copy of the recording: explain", _copied, REFUSED, ("first", "second"), quick=True)
    yield Case(
        "collision: a mesh called telemetry.csv: convert", _table_as_mesh, REFUSED, ("telemetry.csv", "scene.json")
    )
