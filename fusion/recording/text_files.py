"""Text files of recordings: lines, lists of stamped images, numbers; every error names file and line."""

import math
from collections.abc import Iterator
from pathlib import Path

from fusion.errors import RecordingError


def read_text(path: Path) -> str:
    """The text of a UTF-8 file. Raises RecordingError."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise RecordingError("the file cannot be read", path, error.strerror or error) from error
    except UnicodeDecodeError as error:
        raise RecordingError(
            "the file is not text", path, f"byte {error.object[error.start]} at {error.start}"
        ) from error


def data_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Numbered lines (from 1) of a text file without blank lines and `#` comments. Raises RecordingError."""
    for number, line in enumerate(read_text(path).split("\n"), start=1):
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


def read_image_list(path: Path) -> tuple[list[float], list[str]]:
    """Time stamps [s] and file names of a TUM list (`timestamp filename` a line), unsorted. Raises RecordingError."""
    stamps, names = [], []
    for line, text in data_lines(path):
        parts = text.split(maxsplit=1)
        if len(parts) != 2 or "\0" in text:
            raise RecordingError("a line cannot be read", f"{path}, line {line}", repr(text[:60]), "timestamp filename")
        stamps.append(number(parts[0], path, line))
        names.append(parts[1])
    return stamps, names
