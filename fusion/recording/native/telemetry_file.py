"""`telemetry.csv`: what else was logged, one column a quantity."""

import csv
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.errors import RecordingError
from fusion.files.reading import read_text
from fusion.quantity import FAR
from fusion.recording.native.text_files import stamp

# what a log can hold: beyond, it is an error code or another unit
PLAUSIBLE = {
    "turntable_deg": (-1e6, 1e6),  # 2800 turns
    "temperature_c": (-40.0, 150.0),
    "ambient_lux": (0.0, 200_000.0),
    "distance_m": (0.0, FAR),
    "shutter_s": (0.0, 1e4),
}

# seconds since any moment: written to a microsecond
CLOCKS = ("timestamp", "device_s", "host_s")
RECORDED = (*CLOCKS, "missed")  # columns that `fusion record` writes, before what the device tells


def read_telemetry(path: Path, notes: list[str] | None = None) -> dict[str, NDArray[np.float64]]:
    """Columns (m,) of a telemetry file by their name, in the order of time; NaN where blank or not possible.

    Columns that hold words are left out; of those that this program reads, that is told.

    Args:
        path: a table with commas and a header row.
        notes: what was left out or sorted is appended here.

    Raises:
        RecordingError: no column `timestamp`, a row of another length, a stamp that is not a number of seconds.
    """
    return telemetry_in(read_text(path, RecordingError, "the table"), path, [] if notes is None else notes)


def telemetry_in(text: str, path: Path, notes: list[str]) -> dict[str, NDArray[np.float64]]:
    """The same of a text that stands in another file; `path` names it. Raises as `read_telemetry`."""
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
    words: dict[str, str] = {}
    endless: dict[str, list[int]] = {}
    for line, row in rows[1:]:
        if len(row) != len(names):
            raise RecordingError("a row has another length", f"{path}, line {line}", len(row), f"{len(names)} values")
        for name, cell in zip(names, row, strict=True):
            value = _value(cell) if name != "timestamp" else stamp(cell, path, line)
            if value is None:
                words.setdefault(name, f"{cell.strip()[:20]!r} in line {line} is no number")
            elif cell.strip() and not math.isfinite(value):
                endless.setdefault(name, []).append(line)
            values[name].append(math.nan if value is None else value)
    if any(len(column) != len(rows) - 1 for column in values.values()):
        raise RecordingError("a column appears twice", path, ",".join(names)[:80], "different names")
    notes += [f"{name} in {path.name} is left out: {words[name]}" for name in PLAUSIBLE if name in words]
    notes += [
        f"{len(lines)} of {len(rows) - 1} values of {name} in {path.name} are left out: "
        f"no finite numbers, the first in line {lines[0]}"
        for name, lines in endless.items()
        if name in PLAUSIBLE and name not in words
    ]
    columns = {name: np.array(column, float) for name, column in values.items() if name not in words}
    steps_back = int((np.diff(columns["timestamp"]) < 0).sum())
    if steps_back:
        notes.append(f"{path.name} is not in the order of time ({steps_back} steps back): sorted")
        order = np.argsort(columns["timestamp"], kind="stable")
        columns = {name: column[order] for name, column in columns.items()}
    return {name: _possible(name, column, path, notes) for name, column in columns.items()}


def _possible(name: str, column: NDArray[np.float64], path: Path, notes: list[str]) -> NDArray[np.float64]:
    """The column without what it cannot hold."""
    low, high = PLAUSIBLE.get(name, (-np.inf, np.inf))
    wrong = (column < low) | (column > high)
    if not wrong.any():
        return column
    notes.append(
        f"{int(wrong.sum())} of {len(column)} values of {name} in {path.name} are left out: "
        f"{column[wrong][0]:.4g} lies outside {low:g} to {high:g}{_unit_meant(name, column, high)}"
    )
    return np.where(wrong, np.nan, column)


def _unit_meant(name: str, column: NDArray[np.float64], high: float) -> str:
    """Metres that are all a thousand times too large are millimetres."""
    known = column[np.isfinite(column)]
    return " (metres: these look like millimetres)" if name == "distance_m" and (known > high).all() else ""


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
    return f"{value:.6f}" if name in CLOCKS else f"{value:.9g}"
