"""Scans as a user would, takes down what is said, and measures against the truth."""

import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tools.sets.judging.command import fusion
from tools.sets.judging.said import content
from tools.sets.two_passes.judged import measured, outer_points

HEAD = f"{'case':28} told  {'verdict':9} {'rms mm':>6} {'seen %':>6}  what is said"


@dataclass(frozen=True)
class Judged:
    """One case; `told` is what was asked for, or that nothing was; rms [m], NaN where nothing was handed out."""

    name: str
    told: bool
    verdict: str
    rms: float
    covered: float
    said: tuple[str, ...]


def judged(folder: Path) -> Judged:
    """A case's folder, made before."""
    truth = json.loads((folder / "truth" / "truth.json").read_text(encoding="utf-8"))
    scan = folder / "scan_1"
    shutil.rmtree(scan, ignore_errors=True)
    ran = fusion("turntable", folder / "pass_1", "-o", scan, "--no-report", *truth.get("options", ()))
    (folder / "terminal.txt").write_text(ran.terminal, encoding="utf-8")
    if ran.status:
        return Judged(truth["name"], _holds(truth["said"], [ran.last]), "refused", *2 * (float("nan"),), (ran.last,))
    settings = content(scan / "settings.json")
    lights = [x for x in settings["judgement"] if x["level"] != "ok"]
    said = [*(f"{x['subject']}: {x['reason']} {x['do']}" for x in lights), *settings["footnotes"]]
    verdict = str(content(scan / "turntable.json").get("verdict", ""))
    told = _holds(truth["said"], said)
    return Judged(truth["name"], told, verdict, *measured(folder, "scan_1", outer_points(folder)), tuple(said))


def _holds(asked: str, said: Sequence[str]) -> bool:
    return bool(re.search(asked, "\n".join(said), re.IGNORECASE))


def line(one: Judged) -> str:
    """A line, and one for each thing said."""
    head = (
        f"{one.name:28} {'yes' if one.told else 'NO':5} {one.verdict:9} {one.rms * 1e3:6.2f} {one.covered * 100:6.1f}"
    )
    return "\n".join([head, *(f"    {text}" for text in one.said)])


def row(one: Judged) -> dict[str, Any]:
    return asdict(one)


def summary(cases: list[Judged]) -> str:
    return f"{sum(one.told for one in cases)} of {len(cases)} are told of as asked"
