"""Size, place and hand of the scene through every format: each written, opened by `fusion`, and measured."""

import math
import shutil
import subprocess
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import fusion
from tools.formats.cases import Case, cases
from tools.formats.measure import Found, found
from tools.formats.writers.programs import Tools

SIZE_PCT, PLACE_PX = 0.1, 0.2  # what is asked


@dataclass(frozen=True)
class Row:
    """One format; `measured` is empty where it could not be opened, and `told` says why."""

    format: str
    writer: str
    recognised: str
    measured: dict[str, float | str]
    reached: bool
    foreign: str
    told: str


def judged(tools: Tools, work: Path, seed: int) -> list[Row]:
    """One row for each case; nothing is drawn, `seed` is for the other parts."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    return [row(case, work) for case in cases(tools) if tools.only in case.name]


def row(case: Case, work: Path) -> Row:
    """Write, open, measure."""
    place = work / "".join(c if c.isalnum() else "_" for c in case.name)
    try:
        path = case.write(case.take, place)
        recording = fusion.open_recording(path, case.said)
        measured = found(recording, case.take)
        if not case.clock:
            measured = replace(measured, clock_us=math.nan)
    except (OSError, ValueError, IndexError, subprocess.CalledProcessError, fusion.FusionError) as error:
        return Row(case.name, case.writer, "", {}, False, case.foreign, " ".join(str(error).split()))
    told = "; ".join(recording.warnings)
    return Row(case.name, case.writer, recording.format, asdict(measured), good(measured), case.foreign, told)


def good(it: Found) -> bool:
    """Whether what is asked holds."""
    return it.hand == "right" and it.size_pct <= SIZE_PCT and it.place_px <= PLACE_PX


HEAD = (
    f"{'format':26s} {'written by':24s} {'size %':>7s} {'place px':>8s} {'hand':9s} {'left mm':>7s} {'turn deg':>8s} "
    f"{'shift mm':>8s} {'color px':>8s} {'clock us':>8s} foreign"
)


def line(row: Row) -> str:
    """As text."""
    begin = f"{row.format:26s} {row.writer:24s} "
    if not row.measured:
        return f"{begin} not opened: {row.told}"
    m = row.measured
    numbers = [(m["size_pct"], "7.4f"), (m["place_px"], "8.4f")]
    first = " ".join(format(v, f) for v, f in numbers)
    rest = [(m["spread_mm"], 7, 3), (m["turn_deg"], 8, 4), (m["shift_mm"], 8, 3), (m["color_px"], 8, 3),
            (m["clock_us"], 8, 1)]  # fmt: skip
    last = " ".join(f"{v:{w}.{d}f}" if math.isfinite(float(v)) else f"{'-':>{w}s}" for v, w, d in rest)
    return f"{begin}{first} {m['hand']!s:9s} {last} {'' if row.reached else 'NOT REACHED '}{row.foreign or '-'}"
