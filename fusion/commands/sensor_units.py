"""`fusion sensor units`: many units of one camera, measured on one or several dates."""

import argparse
import csv
import io
import json
import sys
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.errors import FusionError, SensorError

if TYPE_CHECKING:
    from fusion.simulation.exporting.units import Measured, Units

COLUMNS = ("sensor", "unit", "date")
LIST = "a CSV file with a column sensor (and unit, date), or a folder of folders with a sensor.json each"
YEAR = 365.25  # days


def run_units(options: argparse.Namespace) -> int:
    """Print the table of the spread, and write units.json and the page where a folder is named."""
    from fusion.progress import stage
    from fusion.recording.camera_presets import find_camera
    from fusion.simulation.exporting.loss import usual_camera
    from fusion.simulation.exporting.units import units

    models = measured(Path(options.sensor))
    camera = usual_camera(models[0].sensor) if options.camera is None else find_camera(options.camera)
    found = units(models, camera)
    if options.output is not None:
        from fusion.report.units import units_report

        with options.claim.folder() as partial, stage("report"):
            units_report(partial / "report.html", found, "fusion " + " ".join(sys.argv[1:]))
            (partial / "units.json").write_text(json.dumps(found.to_dict(), indent=1) + "\n", encoding="utf-8")
    print(json.dumps(found.to_dict(), indent=1) if options.json else "\n".join(_lines(found)))
    return 0


def measured(place: Path) -> list["Measured"]:
    """The models that a list or a folder names.

    Raises:
        FusionError: there is no such place, it holds nothing, or a date cannot be read; SensorError of a file.
    """
    from fusion.sensor.file import read_sensor
    from fusion.simulation.exporting.units import Measured

    if place.is_dir():
        rows = [(path, path.parent.name, "") for path in sorted(place.glob("*/sensor.json"))]
    elif place.is_file():
        rows = list(_rows(place))
    else:
        raise FusionError("there is nothing to compare", place, "nothing", LIST)
    if not rows:
        raise FusionError("there is nothing to compare", place, "no sensor.json", LIST)
    found = []
    for path, unit, day in rows:
        sensor = read_sensor(path)
        found.append(Measured(unit or sensor.serial or path.parent.name, _years(day, place), sensor))
    return found


def _rows(path: Path) -> Iterator[tuple[Path, str, str]]:
    from fusion.files.reading import read_text

    lines = list(csv.DictReader(io.StringIO(read_text(path, FusionError, "the list")), skipinitialspace=True))
    for number, line in enumerate(lines, start=2):
        cells = {
            str(key).strip(): (value or "").strip() for key, value in line.items() if isinstance(value, str | None)
        }
        if not cells.get("sensor"):
            shown = ", ".join(cells)[:80] or "nothing"
            raise FusionError(
                "a line names no sensor", f"{path}, line {number}", shown, "columns " + ", ".join(COLUMNS)
            )
        yield path.parent / cells["sensor"], cells.get("unit", ""), cells.get("date", "")


def _years(day: str, place: Path) -> float:
    if not day:
        return float("nan")
    try:
        return date.fromisoformat(day).toordinal() / YEAR
    except ValueError:
        raise SensorError("a date cannot be read", place, day[:40], "YYYY-MM-DD, such as 2026-11-26") from None


def _lines(found: "Units") -> list[str]:
    import numpy as np

    head = f"{'depth':>6} {'mean':>9} {'between units':>26} {'between dates':>26} {'drift a year':>28}"
    lines = [
        f"{len(found.names)} units, {len(found.unit)} models; mean error before walls, in mm, with 95 % intervals",
        head,
    ]
    for n, depth in enumerate(found.depths):
        cells = [f"{depth:>6g} {1e3 * float(np.mean(found.bias[:, n])):>9.3f}"]
        for one, width in ((found.between, 26), (found.within, 26), (found.drift, 28)):
            known = np.isfinite(one.value[n])
            text = f"{1e3 * one.value[n]:.3f} ({1e3 * one.low[n]:.3f} to {1e3 * one.high[n]:.3f})" if known else "-"
            cells.append(f"{text:>{width}}")
        lines.append(" ".join(cells))
    return lines
