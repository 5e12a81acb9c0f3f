"""Text files of recordings: lines, lists of stamped images, numbers; every error names file and line."""

import math
from collections.abc import Iterator
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.files.reading import read_text

LATEST = 1e12  # [s] 32 000 years: milliseconds and finer since 1970 lie beyond


def data_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Numbered lines (from 1) of a text file without blank lines and `#` comments. Raises RecordingError."""
    for number, line in enumerate(read_text(path, RecordingError).split("\n"), start=1):
        line = line.strip()
        if line and not line.startswith("#"):
            yield number, line


def number(text: str, path: Path, line: int) -> float:
    """A finite number. Raises RecordingError with the line."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordingError("a number cannot be read", f"{path}, line {line}", repr(text[:40]), "a finite number")
    return value


def stamp(text: str, path: Path, line: int) -> float:
    """A time stamp [s]. Raises RecordingError with the line."""
    value = number(text, path, line)
    if abs(value) > LATEST:
        raise RecordingError("a time stamp is not in seconds", f"{path}, line {line}", repr(text[:40]), "seconds")
    return value


def read_image_list(path: Path) -> tuple[list[float], list[str]]:
    """Time stamps [s] and file names of a TUM list (`timestamp filename` a line), unsorted.

    Raises:
        RecordingError: a line of another form, a stamp that is none in seconds, a name that leads out of the folder.
    """
    stamps, names = [], []
    for line, text in data_lines(path):
        parts = text.split(maxsplit=1)
        if len(parts) != 2:
            raise RecordingError("a line cannot be read", f"{path}, line {line}", repr(text[:60]), "timestamp filename")
        stamps.append(stamp(parts[0], path, line))
        names.append(parts[1])
    return stamps, all_inside(path.parent, names, RecordingError, path)
