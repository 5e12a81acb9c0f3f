"""`fusion sensor units`: many units of one camera, measured on one or several dates."""

import argparse
import csv
import io
import re
import sys
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.errors import FusionError, SensorError
from fusion.files.json_values import json_text

if TYPE_CHECKING:
    from fusion.simulation.exporting.quantities import Quantities, Reading
    from fusion.simulation.exporting.units import Measured, Units

COLUMNS = ("sensor", "unit", "date")
KINDS = ("sensor.json", "camera.json", "evaluation.json")
LIST = f"a CSV file with a column sensor (and unit, date), or a folder of folders with a {KINDS[0]} each"
FORMAT = "fusion-evaluation/"
DAY = re.compile(r"(?<!\d)\d{4}-\d{2}-\d{2}(?!\d)")  # in a folder's name
YEAR = 365.2425  # days, of the Gregorian calendar


def run_units(options: argparse.Namespace) -> int:
    """Print the table of the spread, and write units.json and the page where a folder is named."""
    from fusion.progress import stage
    from fusion.recording.cameras.presets import find_camera
    from fusion.simulation.exporting.loss import usual_camera
    from fusion.simulation.exporting.units import units

    rows = listed(Path(options.sensor))
    if rows[0][0].name.endswith(KINDS[1:]):
        return _run_quantities(options, read(rows))
    models = measured(rows)
    camera = usual_camera(models[0].sensor) if options.camera is None else find_camera(options.camera)
    found = units(models, camera)
    if options.output is not None:
        from fusion.report.evaluations.units import units_report

        with options.claim.folder() as partial, stage("report"):
            units_report(partial / "report.html", found, "fusion " + " ".join(sys.argv[1:]))
            (partial / "units.json").write_text(json_text(found.figures()) + "\n", encoding="utf-8")
    print(json_text(found.figures()) if options.json else "\n".join(_lines(found)))
    return 0


def _run_quantities(options: argparse.Namespace, readings: list["Reading"]) -> int:
    """The same for what other results state."""
    from fusion.progress import stage
    from fusion.simulation.exporting.quantities import quantities

    found = quantities(readings)
    if options.output is not None:
        from fusion.report.evaluations.quantities import quantities_report

        with options.claim.folder() as partial, stage("report"):
            quantities_report(partial / "report.html", found, "fusion " + " ".join(sys.argv[1:]))
            (partial / "units.json").write_text(json_text(found.figures()) + "\n", encoding="utf-8")
    print(json_text(found.figures()) if options.json else "\n".join(_quantity_lines(found)))
    return 0


def listed(place: Path) -> list[tuple[Path, str, float]]:
    """Files that a list or a folder names, the unit of each and its date [years].

    Raises:
        FusionError: there is no such place, it holds nothing, its files are of several kinds, or a date cannot be read.
    """
    if place.is_dir():
        found = {kind: sorted(place.glob(f"*/{kind}")) for kind in KINDS}
        paths = next((some for some in found.values() if some), [])
        days = [DAY.search(path.parent.name) for path in paths]
        # a file's serial number tells the unit, and where there is none its folder's name
        rows = [(path, "", day[0] if day else "") for path, day in zip(paths, days, strict=True)]
    elif place.is_file():
        rows = list(_rows(place))
    else:
        raise FusionError("there is nothing to compare", place, "nothing", LIST)
    if not rows:
        raise FusionError("there is nothing to compare", place, " or ".join(f"no {kind}" for kind in KINDS), LIST)
    kinds = sorted({next((kind for kind in KINDS[1:] if path.name.endswith(kind)), KINDS[0]) for path, *_ in rows})
    if len(kinds) > 1:
        raise FusionError("these results state different things", place, ", ".join(kinds), "files of one kind")
    return [(path, unit, _years(day, place)) for path, unit, day in rows]


def measured(rows: list[tuple[Path, str, float]]) -> list["Measured"]:
    """The sensor models. Raises SensorError of a file."""
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.exporting.units import Measured

    found = []
    for path, unit, date_years in rows:
        sensor = read_sensor(path)
        found.append(Measured(unit or sensor.serial or path.parent.name, date_years, sensor))
    return found


def read(rows: list[tuple[Path, str, float]]) -> list["Reading"]:
    """What cameras, or evaluations, state. Raises FusionError of a file."""
    from fusion.files.json_file import read_json
    from fusion.recording.native.camera_file import read_camera
    from fusion.simulation.exporting.quantities import Reading, stated_by_camera, stated_by_evaluation

    found = []
    for path, unit, date_years in rows:
        if path.name.endswith("camera.json"):
            camera = read_camera(path)
            values, serial = stated_by_camera(vars(camera)), camera.serial
        else:
            content = read_json(path, FusionError, "the evaluation")
            if not str(content.get("format")).startswith(FORMAT):
                raise FusionError("this is no evaluation", path, str(content.get("format"))[:40], FORMAT + "1")
            try:
                values, serial = stated_by_evaluation(content), str(content["camera"]["serial"])
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                expected = "evaluation.json as `fusion evaluate` writes it"
                raise FusionError("an evaluation cannot be used", path, f"{error}"[:80], expected) from None
        found.append(Reading(unit or serial or path.parent.name, date_years, values))
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
        return 1 + (date.fromisoformat(day).toordinal() - 1) / YEAR  # the first day is that of the year 1
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


def _quantity_lines(found: "Quantities") -> list[str]:
    from fusion.report.evaluations.quantities import table_rows

    head = ["quantity", "mean", "between units", "between dates", "drift a year"]
    table = [head, *table_rows(found)]
    widths = [max(len(row[n]) for row in table) for n in range(len(head))]
    told = f"{len(found.names)} units, {len(found.unit)} results; with 95 % intervals"
    return [
        told,
        *("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table),
    ]
