"""`telemetry.csv`: what else was logged, one column a quantity."""

import csv
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.errors import RecordingError
from fusion.recording.text_files import read_text


def read_telemetry(path: Path) -> dict[str, NDArray[np.float64]]:
    """Columns (m,) of a telemetry file by their name, NaN where blank; columns that hold words are left out.

    Raises:
        RecordingError: no column `timestamp`, a row of another length, a stamp that is not a number.
    """
    # NUL is refused by the csv module of Python 3.11 only
    text = read_text(path).replace("\0", "?")
    try:
        rows = [
            (i, row) for i, row in enumerate(csv.reader(text.splitlines()), 1) if row and not row[0].startswith("#")
        ]
    except csv.Error as error:
        raise RecordingError("the table cannot be read", path, error) from error
    names = [name.strip() for name in rows[0][1]] if rows else []
    if "timestamp" not in names:
        raise RecordingError(
            "the table has no column timestamp", path, ",".join(names)[:60] or "an empty file", "a header row"
        )
    values: dict[str, list[float]] = {name: [] for name in names}
    words = set()
    for line, row in rows[1:]:
        if len(row) != len(names):
            raise RecordingError("a row has another length", f"{path}, line {line}", len(row), f"{len(names)} values")
        for name, cell in zip(names, row, strict=True):
            value = _value(cell)
            if value is None and name == "timestamp":
                raise RecordingError("a time stamp cannot be read", f"{path}, line {line}", repr(cell[:40]), "seconds")
            if value is None:
                words.add(name)
            values[name].append(math.nan if value is None else value)
    if any(len(column) != len(rows) - 1 for column in values.values()):
        raise RecordingError("a column appears twice", path, ",".join(names)[:80], "different names")
    return {name: np.array(column, float) for name, column in values.items() if name not in words}


def telemetry_text(telemetry: Mapping[str, ArrayLike]) -> str:
    """The content of a telemetry file of columns (m,); NaN becomes blank."""
    names = ["timestamp", *[name for name in telemetry if name != "timestamp"]]
    columns = [np.asarray(telemetry[name], float) for name in names]
    rows = [",".join(_cell(name, v) for name, v in zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(names), *rows]) + "\n"


def _value(cell: str) -> float | None:
    cell = cell.strip()
    try:
        value = float(cell) if cell else math.nan
    except ValueError:
        return None
    return value if math.isfinite(value) else math.nan


def _cell(name: str, value: float) -> str:
    if not math.isfinite(value):
        return ""
    return f"{value:.6f}" if name == "timestamp" else f"{value:.9g}"
