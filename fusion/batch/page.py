"""index.html of a batch: a row with picture and light for each recording, to be filtered and sorted."""

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path
from urllib.parse import quote

from fusion.batch.job import JobRow
from fusion.batch.work import BOOKS
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
    table = _filters([light for light, number in count.items() if number]) + _table(home, rows, columns)
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


def _filters(lights: Sequence[str]) -> str:
    boxes = "".join(
        f'<label><input type="checkbox" class="batch-light" value="{escape(light)}" checked> {escape(light)}</label> '
        for light in lights
    )
    text = '<input type="search" id="batch-text" placeholder="name, reason" aria-label="Filter by name or reason">'
    return f'<p class="batch-filters">{text} {boxes}<span id="batch-count" role="status"></span></p>'


def _table(home: Path, rows: Sequence[JobRow], columns: Sequence[str]) -> str:
    heads = ["", "recording", "light", "status", "reason", *(name.partition(".")[2] for name in columns)]
    top = "".join(f'<th scope="col" tabindex="0">{escape(head)}</th>' for head in heads)
    body = "".join(_row(home, row, columns) for row in rows)
    style = (
        "<style>.batch-filters{display:flex;flex-wrap:wrap;gap:1em;align-items:center}#batch thead th{cursor:pointer}"
        "#batch img{display:block;max-width:96px;max-height:64px}#batch td,#batch th{vertical-align:middle}"
        "#batch th,#batch td{white-space:nowrap;word-break:normal;overflow-wrap:normal;text-align:left}"
        "#batch .number{text-align:right}#batch .reason{white-space:normal;min-width:18em}"
        ".batch-ok{color:#00785a}.batch-warning{color:#8a5a00;font-weight:bold}.batch-bad{color:#b04400;font-weight:bold}"
        "@media(prefers-color-scheme:dark){.batch-ok{color:#4fd1a5}.batch-warning{color:#f0b64a}.batch-bad{color:#ff8a50}}"
        "</style>"
    )
    return (
        f'{style}<div class="scroll"><table id="batch"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'
    )


def _row(home: Path, row: JobRow, columns: Sequence[str]) -> str:
    picture = home / BOOKS / f"{row.folder}.jpg"
    image = ""
    if row.folder and picture.is_file():
        data = base64.b64encode(picture.read_bytes()).decode("ascii")
        image = f'<img alt="" src="data:image/jpeg;base64,{data}">'
    inside = "/report.html" if row.folder and (home / row.folder / "report.html").is_file() else "/"
    name = escape(row.recording)
    link = f'<a href="{quote(row.folder)}{inside}">{name}</a>' if row.folder else name
    cells = "".join(_number(row.numbers.get(column)) for column in columns)
    level = LIGHTS[row.light]
    return (
        f'<tr data-light="{escape(row.light)}"><td>{image}</td><th scope="row">{link}</th>'
        f'<td class="batch-{level}">{escape(row.light)}</td><td>{escape(row.status)}</td>'
        f'<td class="reason">{escape(row.reason)}</td>{cells}</tr>'
    )


def _number(value: object) -> str:
    if value is None:
        return '<td class="number"></td>'
    return f'<td class="number" data-value="{escape(str(value))}">{escape(shown(value))}</td>'
