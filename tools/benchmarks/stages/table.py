"""From scores to rows of a table, to JSON and to pictures."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.benchmarks.stages.asked import ASKED
from tools.benchmarks.stages.contest import OURS, Score
from tools.benchmarks.stages.judge import disagreements, misses, surface_errors


@dataclass(frozen=True)
class Row:
    """One contestant in one stage: median, lowest and highest round [ms, MiB]; of errors median and 95 % [mm].

    `wrong` says why its result does not count as the work done; "" where it does.
    """

    name: str
    median: float
    low: float
    high: float
    note: str = ""
    wrong: str = ""


@dataclass(frozen=True)
class Table:
    """A stage on a workload: rows, ours first; the ratio to the fastest peer that does the work right, the ratio asked
    for, and complaints."""

    stage: str
    workload: str
    unit: str
    rows: tuple[Row, ...]
    asked: float
    complaints: tuple[str, ...]

    @property
    def best(self) -> float:
        """The fastest peer whose result is right; NaN without one."""
        peers = [row.median for row in self.rows[1:] if np.isfinite(row.median) and not row.wrong]
        return min(peers, default=float("nan"))

    @property
    def ratio(self) -> float:
        """Ours over the best peer."""
        return self.rows[0].median / self.best


def table(stage: str, workload: str, scores: list[Score]) -> Table:
    """The scores of one stage; contestants that could not run have NaN and their excuse."""
    scores = [s for s in scores if stage in s.contestant.stages]
    scores.sort(key=lambda s: s.contestant.name != OURS)
    rows, unit = tuple(_row(stage, workload, s) for s in scores), "ms"
    if stage in ("memory", "error"):
        unit = "MiB" if stage == "memory" else "mm"
    return Table(stage, workload, unit, rows, ASKED[stage, workload], tuple(disagreements(stage, workload, scores)))


def _row(stage: str, workload: str, score: Score) -> Row:
    name, nan = score.contestant.name, float("nan")
    if score.excuse:
        return Row(name, nan, nan, nan, f"did not run: {score.excuse}")
    if stage == "error" and score.arrays:
        found = surface_errors(workload, score.arrays)
        return Row(name, found["median"], found["median"], found["95 %"], f"mean {found['mean']:.2f} mm")
    values = [a["memory"] for a in score.answers] if stage == "memory" else score.times(stage)
    wrong = "" if name == OURS else misses(stage, workload, score)
    return Row(name, float(np.median(values)), min(values), max(values), _note(stage, score), wrong)


def _note(stage: str, score: Score) -> str:
    wanted = {
        "align": ("shift_mm", "turn_deg", "largest_mm"),
        "raycast": ("depth_error", "seen"),
        "extract": ("triangles",),
        "update": ("lost", "drift_mm"),
        "distances": ("mean_um",),
    }.get(stage, ())
    found = {key: score.value(key) for key in wanted}
    return ", ".join(f"{key} {value:.3g}" for key, value in found.items() if value is not None)


def text(t: Table) -> str:
    """A table for the terminal."""
    verdict = "" if np.isnan(t.ratio) else f"ratio {t.ratio:.2f}, asked {t.asked:g}"
    lines = [f"{t.stage}, {t.workload}: {verdict}"]
    lines += [f"  {r.name:26s}{r.median:10.2f} {t.unit}  ({r.low:.2f} to {r.high:.2f})  {_said(t, r)}" for r in t.rows]
    return "\n".join(lines + [f"  WRONG: {c}" for c in t.complaints])


def _said(t: Table, row: Row) -> str:
    ratio = t.rows[0].median / row.median
    parts = [row.note, f"ours over it {ratio:.2f}" if row is not t.rows[0] and np.isfinite(ratio) else ""]
    return "; ".join(p for p in [*parts, f"does not count: {row.wrong}" if row.wrong else ""] if p)


def draw(tables: list[Table], path: Path) -> None:
    """One picture of a stage: bars with their spread, a line where the asked ratio lies."""
    from matplotlib.figure import Figure

    from fusion.report.kit import palette

    with palette.styled():
        figure = Figure(figsize=(8, 0.6 + sum(0.55 + 0.36 * len(t.rows) for t in tables)), layout="constrained")
        axes = figure.subplots(len(tables), squeeze=False, height_ratios=[len(t.rows) for t in tables])[:, 0]
        for ax, t in zip(axes, tables, strict=True):
            rows = [r for r in t.rows if np.isfinite(r.median)]
            at = np.arange(len(rows))
            spread = [[r.median - r.low for r in rows], [r.high - r.median for r in rows]]
            colors = [palette.BLUE if r.name == OURS else palette.GREY for r in rows]
            ax.barh(at, [r.median for r in rows], xerr=spread, color=colors, height=0.6)
            if np.isfinite(t.ratio):
                goal = t.asked * t.best
                ax.axvline(goal, color=palette.ORANGE)
                ax.text(goal, len(rows) - 0.55, " asked", color=palette.ORANGE, fontsize=8, va="bottom")
            ax.set_yticks(at, [f"{r.name}{' (wrong)' if r.wrong else ''}  {r.median:.3g}" for r in rows])
            ax.invert_yaxis()
            ax.set_title(f"{t.stage}, {t.workload} [{t.unit}]")
        figure.savefig(path, facecolor="white", dpi=110)
