"""index.html of a batch: a row with picture and light for each recording, to be filtered and sorted."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from fusion.batch.job import JobRow
from fusion.batch.work import BOOKS
from fusion.report.kit.html import markup
from fusion.report.kit.page import Number, Page, Section, write_page
from fusion.report.kit.tables import shown

# what a person looks at first, by the endings of their names; the tables have all
TELLING = (
    "radial_rms", "axial_rms", "closure.distance", "radius", "accuracy.rms", "accuracy.median", "completeness.rms",
    "agreement.median_m", "scale", "bias.offset_m", "noise.axial_m", "depth.std_m.median", "shares.valid",
    "frames_used", "frames",
)  # fmt: skip
MOST = 6  # of them
LIGHTS = {"good": "ok", "done": "ok", "doubtful": "warning", "failed": "bad"}


def write_index(home: Path, rows: Sequence[JobRow], words: Sequence[str]) -> None:
    """The page, whole or not at all."""
    count = {light: sum(row.light == light for row in rows) for light in LIGHTS}
    stopped = sum(row.status == "stopped" for row in rows)
    numbers = [Number(light, str(number)) for light, number in count.items() if number]
    numbers += [Number("stopped", str(stopped), note="tried again by the next run")] if stopped else []
    columns = _columns(rows)
    table = markup(
        "batch/rows.html",
        lights=[light for light, number in count.items() if number],
        heads=["", "recording", "light", "status", "reason", *(name.partition(".")[2] for name in columns)],
        rows=[_line(home, row, columns) for row in rows],
        shown=shown,
    )
    page = Page(
        title=f"{len(rows)} recordings",
        subtitle=" ".join(words),
        numbers=numbers,
        sections=[
            Section("Results", "A click on a column sorts. All numbers: results.csv, results.parquet.", html=table)
        ],
        dated=False,  # the same rows, the same page
        script=Path(__file__).with_name("page.js").read_text(encoding="utf-8"),
    )
    write_page(home / "index.html", page)


def _columns(rows: Sequence[JobRow]) -> list[str]:
    """Names of the numbers that the page shows: telling ones first, else the first that differ between rows."""
    values: dict[str, set[object]] = {}
    for row in rows:
        for name, value in row.numbers.items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                values.setdefault(name, set()).add(value)
    telling = [name for ending in TELLING for name in values if name.endswith(f".{ending}")]
    differing = [name for name, found in values.items() if len(found) > 1]
    return list(dict.fromkeys([*telling, *differing]))[:MOST]


@dataclass(frozen=True)
class _Line:
    """A recording as the table shows it."""

    name: str
    light: str
    status: str
    reason: str
    level: str
    link: str  # "" where nothing was written
    picture: str  # JPEG as base64, "" where there is none
    numbers: Sequence[object]


def _line(home: Path, row: JobRow, columns: Sequence[str]) -> _Line:
    picture = home / BOOKS / f"{row.folder}.jpg"
    data = base64.b64encode(picture.read_bytes()).decode("ascii") if row.folder and picture.is_file() else ""
    inside = "/report.html" if row.folder and (home / row.folder / "report.html").is_file() else "/"
    link = f"{quote(row.folder)}{inside}" if row.folder else ""
    numbers = [row.numbers.get(column) for column in columns]
    return _Line(row.recording, row.light, row.status, row.reason, LIGHTS[row.light], link, data, numbers)
