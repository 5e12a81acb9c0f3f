"""What a verdict is worth: a claim is right if its effect, or one it cannot be told from, is true or also right."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tools.trial.scoring import interval

OUTCOMES = ("right", "set", "silent", "quiet", "wrong", "refused")


@dataclass(frozen=True)
class ScoredVerdict:
    """Attributes:
    outcome: "right" by a name, "set" by one that is said to look alike, "silent" or "quiet" (nothing claimed where
        something, or nothing, is missing), "wrong" where any claim is, "refused" without a verdict.
    claims, wrong: established claims, and those of them that are wrong.
    words: what was said, in words.
    """

    outcome: str
    claims: int
    wrong: int
    words: str


@dataclass(frozen=True)
class CaseRow:
    """A case with what was said of it."""

    name: str
    kind: str
    truth: list[str]
    said: ScoredVerdict
    seconds: float


def scored(verdict: dict[str, Any] | None, answer: dict[str, Any], complaint: str = "") -> ScoredVerdict:
    """`verdict`: content of verdict.json, None where there is none."""
    if verdict is None:
        return ScoredVerdict("refused", 0, 0, complaint or "no verdict")
    right = {*answer["truth"], *answer.get("also_right", [])}
    claims = verdict["missing"]
    named = [claim for claim in claims if claim["effect"] in right]
    alike = [c for c in claims if c not in named and right & set(c.get("indistinguishable_from") or [])]
    wrong = len(claims) - len(named) - len(alike)
    words = "; ".join(_words(claim) for claim in claims) or "nothing"
    if wrong:
        outcome = "wrong"
    elif named or alike:
        outcome = "right" if named else "set"
    else:
        outcome = "silent" if answer["truth"] else "quiet"
    return ScoredVerdict(outcome, len(claims), wrong, words)


def line(row: CaseRow) -> str:
    truth = "+".join(row.truth) or "nothing"
    return f"{row.name} {row.kind}: {truth} -> {row.said.words} [{row.said.outcome}] {row.seconds:.0f} s"


def table(rows: Sequence[CaseRow]) -> str:
    """Shares, each with its exact binomial interval."""
    told = [row for row in rows if row.said.outcome != "refused"]
    planted, nulls = [row for row in told if row.truth], [row for row in told if not row.truth]
    claims = sum(row.said.claims for row in told)
    shares = [
        _share("cases with a wrong established claim", _count(told, "wrong"), len(told)),
        _share("wrong ones of established claims", sum(row.said.wrong for row in told), claims),
        _share("right, by name or by set, of those planted", _count(planted, "right", "set"), len(planted)),
        _share("silent, of those planted", _count(planted, "silent"), len(planted)),
        _share("quiet, of nulls", _count(nulls, "quiet"), len(nulls)),
        # a thing that stands elsewhere is no fault of the sensor, and still true
        _share("nulls of which something true was said", _count(nulls, "right", "set"), len(nulls)),
        _share("refused, of all", _count(rows, "refused"), len(rows)),
    ]
    return "\n".join(shares)


def _count(rows: Sequence[CaseRow], *outcomes: str) -> int:
    return sum(row.said.outcome in outcomes for row in rows)


def _share(measure: str, hits: int, of: int) -> str:
    if not of:
        return f"{measure:<46}{'none':>12}"
    low, high = interval(hits, of)
    count = f"{hits} of {of}"
    return f"{measure:<46}{count:>12}  {hits / of:.2f} [{low:.2f}, {high:.2f}]"


def _words(claim: dict[str, Any]) -> str:
    alike = claim.get("indistinguishable_from") or []
    return claim["effect"] + (f" or {', '.join(alike)}" if alike else "")
