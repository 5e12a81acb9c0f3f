"""Frames that a person took back: the lists of a recording name them no more, the images stay."""

from pathlib import Path

from fusion.files.output.publish import atomic_file
from fusion.files.reading import read_text
from fusion.recording.writing.write import LISTS

ASIDE = "undone.txt"  # which stamps were taken back


def strike(folder: Path, spans: list[tuple[float, float]]) -> int:
    """Take the frames of some spans of time (after, up to and without) [s] out of a recording's lists; how many.

    `undone.txt` names their stamps and images.
    """
    aside = []
    for name in LISTS:
        path = folder / f"{name}.txt"
        if path.exists():
            lines = read_text(path).splitlines(keepends=True)
            gone = [line for line in lines if _taken_back(line, spans)]
            with atomic_file(path) as made:
                made.write_text("".join(line for line in lines if line not in gone), encoding="utf-8")
            aside += gone
    (folder / ASIDE).write_text("# timestamp filename\n" + "".join(aside), encoding="utf-8")
    return sum(" depth/" in line for line in aside)


def _taken_back(line: str, spans: list[tuple[float, float]]) -> bool:
    if line.startswith("#"):
        return False
    stamp = float(line.split()[0])
    return any(after + 1e-6 < stamp < until - 1e-6 for after, until in spans)
