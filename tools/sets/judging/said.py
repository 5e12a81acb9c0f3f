"""What a turntable scan told its user about itself."""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tools.sets.judging.command import Ran

VERDICTS = ("good", "doubtful", "failed")


@dataclass(frozen=True)
class Said:
    """Attributes:
    verdict: "good", "doubtful" or "failed"; a scan that ended with status 0 and has no verdict says good by that.
    stated: turntable.json holds a verdict, or the scan ended with status 1.
    alarms: how many lights of settings.json's "judgement" are bad.
    words: warnings, reasons and lights that are not ok, and the last line of a refusal.
    """

    verdict: str
    stated: bool
    status: int
    words: tuple[str, ...]
    alarms: int = 0

    def names(self, pattern: str) -> bool:
        """Whether a warning or reason speaks of it."""
        return any(re.search(pattern, word, re.IGNORECASE) for word in self.words)


def read(output: Path, ran: Ran) -> Said:
    """From turntable.json, settings.json and the exit status."""
    if ran.status:
        return Said("failed", True, ran.status, (ran.last,))
    table, settings = content(output / "turntable.json"), content(output / "settings.json")
    verdict = table.get("verdict")
    lights = [x for x in settings.get("judgement") or () if x.get("level") != "ok"]
    words = [*table.get("reasons", ()), *settings.get("warnings", ())]
    words += [f"{x.get('subject')}: {x.get('reason')}" for x in lights]
    stated = verdict in VERDICTS
    alarms = sum(x.get("level") == "bad" for x in lights)
    return Said(str(verdict) if stated else "good", stated, 0, tuple(dict.fromkeys(map(str, words))), alarms)


def content(file: Path) -> dict[str, Any]:
    """A JSON object, empty where there is no file."""
    return dict(json.loads(file.read_text(encoding="utf-8"))) if file.is_file() else {}
