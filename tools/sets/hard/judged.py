"""Scans a recording of the hard set as a user would, and rules: good or wrong, and what was said of it."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tools.sets.hard.planting import RECOVERABLE
from tools.sets.judging.command import fusion
from tools.sets.judging.measured import angle_errors, compared
from tools.sets.judging.said import Said, content, read

RATIO = 1.5  # of the rms of true poses, within which a mesh is good
COVERED = 0.15  # less of what was seen than the mesh of true poses has: a piece is no good scan
SLIPPED = 3.0  # [deg] rms of the angles: a round thing may be right in shape and smeared in colour


@dataclass(frozen=True)
class Judged:
    """A scan; lengths in metres, NaN where there is no number.

    Attributes:
        good: the mesh is within 1.5 times the rms of true poses, covers what they cover, and nothing forbids it.
        angle: rms [deg] of the angles told, after the best constant.
        axis: places told to have an angle, of all frames.
    """

    name: str
    planted: str
    story: dict[str, Any]
    said: Said
    good: bool
    rms: float
    rms_true: float
    covered: float
    covered_true: float
    angle: float
    placed: int
    seconds: float

    @property
    def slipped(self) -> bool:
        """Good in shape, and yet the angles are not right."""
        return self.good and not self.angle <= SLIPPED

    @property
    def ruling(self) -> str:
        return f"{'good' if self.good else 'wrong'}, said {self.said.verdict}"


def judged(folder: Path) -> Judged:
    """A scan's folder, made before."""
    truth = json.loads((folder / "truth" / "truth.json").read_text(encoding="utf-8"))
    for name in ("result", "posed"):
        shutil.rmtree(folder / name, ignore_errors=True)
    ran = fusion("turntable", folder / "recording", "-o", folder / "result", "--no-report")
    (folder / "terminal.txt").write_text(ran.terminal, encoding="utf-8")
    said, planted = read(folder / "result", ran), truth["planted"]
    true, seen = folder / "truth" / "truth.ply", folder / "truth" / "visible.npz"
    ours = compared(folder / "result" / "mesh.ply", true, folder / "compare", seen)
    theirs = None
    if ours is not None and (not planted or planted in RECOVERABLE):
        poses = [
            "--poses",
            folder / "truth" / "poses.txt",
            "--object",
            "--force",
        ]  # a curved thing alone is taken for bent planes
        fusion("reconstruct", folder / "masked", *poses, "-o", folder / "posed", "--no-report")
        theirs = compared(folder / "posed" / "mesh.ply", true, folder / "compare_posed", seen)
    good = False
    if ours is not None and theirs is not None:
        good = ours.rms <= RATIO * theirs.rms and ours.covered >= theirs.covered - COVERED
    table = content(folder / "result" / "turntable.json")
    errors = angle_errors(table, np.array(truth["angles_rad"], float))
    known = errors[np.isfinite(errors)]
    return Judged(
        folder.name, planted, truth["story"], said, good,
        ours.rms if ours else np.nan, theirs.rms if theirs else np.nan,
        ours.covered if ours else np.nan, theirs.covered if theirs else np.nan,
        float(np.std(known)) if len(known) else np.nan, len(known), ran.seconds,
    )  # fmt: skip


HEAD = f"{'scan':<9}{'ruling':<22}{'rms mm':>7}{'true':>6}{'seen':>6}{'true':>6}{'deg rms':>9}{'placed':>8}  what; said"


def line(one: Judged) -> str:
    """One scan."""
    story = one.story
    what = one.planted.upper() if one.planted else f"{story['shape']} on {story['base']}"
    what += f", {story['camera']}, {story['turned by']}{' with log' if story['log'] else ''}"
    what += f", {story['degrees']:.0f} deg in {story['frames']} (to {story['largest step']:.0f})"
    what += f", wall {story['wall cm']} cm"
    what += "".join(f", {x}" for x in story["extras"])
    mark = " *" if one.slipped else ""
    return (
        f"{one.name:<9}{one.ruling + mark:<22}{1e3 * one.rms:>7.2f}{1e3 * one.rms_true:>6.2f}{one.covered:>6.2f}"
        f"{one.covered_true:>6.2f}{one.angle:>9.2f}{one.placed:>4} /{story['frames']:>3}  {what}"
        + (f"\n{'':<31}{one.said.words[0][:150]}" if one.said.words else "")
    )


def summary(scans: Sequence[Judged]) -> str:
    """Counts of good and wrong by what was said, of scans that could be done and of planted ones."""
    rows = []
    for title, some in (("scans", [s for s in scans if not s.planted]), ("planted", [s for s in scans if s.planted])):
        counts = {
            (good, said): sum(s.good == good and s.said.verdict == said for s in some)
            for good in (True, False)
            for said in ("good", "doubtful", "failed")
        }
        rows.append(f"{title}: {len(some)}")
        for good in (True, False):
            told = ", ".join(f"said {said} {counts[good, said]}" for said in ("good", "doubtful", "failed"))
            rows.append(f"  {'good' if good else 'wrong'} {sum(s.good == good for s in some)}: {told}")
    false_good = [s.name for s in scans if not s.good and s.said.verdict == "good"]
    false_failed = [s.name for s in scans if s.good and s.said.verdict == "failed"]
    rows.append(f"false good: {len(false_good)} of {len(scans)} {' '.join(false_good)}")
    red = [s.name for s in scans if s.name in false_good and s.said.alarms]
    rows.append(f"  of these with a red light or problem on the page: {len(red)} {' '.join(red)}")
    rows.append(f"good, said failed: {len(false_failed)} {' '.join(false_failed)}")
    slipped = [s.name for s in scans if s.slipped and s.said.verdict == "good"]
    rows.append(
        f"good in shape, angles off by more than {SLIPPED:.0f} deg rms (*), said good: {' '.join(slipped) or 'none'}"
    )
    return "\n".join(rows)


def row(one: Judged) -> dict[str, Any]:
    """For JSON; NaN becomes null."""
    told = asdict(one) | {"ruling": one.ruling, "slipped": one.slipped}
    return {k: None if isinstance(x, float) and not np.isfinite(x) else x for k, x in told.items()}
