"""The rows of a batch as one table: results.csv and results.parquet; timings.csv holds what differs from run to run."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fusion.batch.job import JobRow
from fusion.batch.work import Done
from fusion.files.extra import extra
from fusion.files.output.publish import atomic_file

FIRST = ("recording", "name", "status", "light", "reason", "folder", "key")


def columns_of(rows: Sequence[JobRow]) -> dict[str, list[Any]]:
    """Column to its values, None where a row has none; a column of several types is text."""
    columns: dict[str, list[Any]] = {name: [getattr(row, name) for row in rows] for name in FIRST}
    for name in sorted({name for row in rows for name in row.numbers}):
        columns[name] = _alike([row.numbers.get(name) for row in rows])
    return columns


def write_tables(home: Path, rows: Sequence[JobRow]) -> None:
    """results.csv and results.parquet; the same rows, the same bytes. FusionError: pyarrow is not installed."""
    arrow = extra("pyarrow", "batch", "results.parquet", home)
    parquet = extra("pyarrow.parquet", "batch", "results.parquet", home)
    columns = columns_of(rows)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(value) for value in line] for line in zip(*columns.values(), strict=True))
    with atomic_file(home / "results.csv") as partial:
        partial.write_text(text.getvalue(), encoding="utf-8", errors="replace")
    table = arrow.table({name: arrow.array(values) for name, values in columns.items()})
    with atomic_file(home / "results.parquet") as partial:
        parquet.write_table(table, partial)


def write_timings(home: Path, done: Sequence[Done]) -> None:
    """timings.csv: what each job took in this run, and where."""
    lines = ["recording,folder,command_s,job_s,worker"]
    for one in done:
        named = one.row.recording.replace('"', '""')
        lines.append(f'"{named}",{one.row.folder},{one.seconds:.3f},{one.whole_s:.3f},{one.worker}')
    with atomic_file(home / "timings.csv") as partial:
        partial.write_text("\n".join([*lines, ""]), encoding="utf-8", errors="replace")


def _alike(values: list[Any]) -> list[Any]:
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} and len(kinds) == 2:
        return [None if value is None else float(value) for value in values]
    return [None if value is None else str(value) for value in values] if len(kinds) > 1 else values


def _cell(value: Any) -> str:
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)
