"""One run: a base is spoiled, `fusion explain` runs as a command of its own process, its verdict is scored."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.sets.judging.command import fusion
from tools.sets.judging.said import content
from tools.trial.spoiled.bases import Base
from tools.trial.spoiled.case import Spoiled, put
from tools.trial.spoiled.catalogue import SPOILS
from tools.trial.spoiled.scoring import Score, score

LIMIT = 900  # [s]


@dataclass(frozen=True)
class Run:
    """What was run and what came of it; `held` and `factor` are chi2 after the claims and `nuisances.pose_factor`."""

    number: int
    base: str
    null: bool
    spoil: str
    text: str
    score: Score
    seconds: float
    headline: str
    chi2: float | None = None


def run(base: Base, number: int, spoil: str, seed: int, folder: Path, keep: bool) -> Run:
    """The spoil's own random numbers depend on seed, number of the base and name of the spoil alone."""
    rng = np.random.default_rng([seed, number, *spoil.encode()])
    return answered(base, SPOILS[spoil](base.case, rng), number, spoil, folder, keep)


def answered(base: Base, spoiled: Spoiled, number: int, spoil: str, folder: Path, keep: bool) -> Run:
    """The command's answer to a spoiled case, scored."""
    recordings, sensor = put(spoiled.case, folder / "case")
    out = folder / "explained"
    ran = fusion("explain", *recordings, "--sensor", sensor, "-o", out, "--no-report", "--overwrite", limit=LIMIT)
    verdict = content(out / "verdict.json") if ran.status == 0 else {}
    judged = score(verdict or None, ran, base, spoiled)
    if not keep:
        shutil.rmtree(folder / "case")
    (folder / "terminal.txt").write_text(ran.terminal, encoding="utf-8")
    held = (verdict.get("fit") or {}).get("heldout") or {}
    headline = str(verdict.get("headline") or ran.last)
    return Run(
        number, base.name, not base.missing, spoil, spoiled.text, judged, ran.seconds, headline,
        held.get("chi2_per_dof_after"),
    )  # fmt: skip


def look(file: Path, entry: dict[str, object]) -> None:
    """Appends a line to the log of looks."""
    head = "" if file.is_file() else ",".join(entry) + "\n"
    with file.open("a", encoding="utf-8") as log:
        log.write(head + ",".join(json.dumps(x) if "," in str(x) else str(x) for x in entry.values()) + "\n")
