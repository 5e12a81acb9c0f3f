"""What a verdict is worth against what is true after a spoil: strictly, claim by claim."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tools.sets.judging.command import Ran
from tools.trial.spoiled.bases import Base
from tools.trial.spoiled.case import Spoiled, Told

# the same variable said in another way
SAME = {"range": "depth", "disparity": "depth", "material": "reflectance", "temperature": "time"}


@dataclass(frozen=True)
class Score:
    """Attributes:
    outcome: "right", "set" (the truth is in the claim's set of look-alikes), "silent", "WRONG", "refused", "failed".
    told: whether the spoil is told, by claim, nuisance, outlier, repeat or headline; None for the control.
    how: by which of them.
    wrong: claims that are wrong, with the reason where the name is right.
    claims: all established ones.
    """

    outcome: str
    told: bool | None
    how: tuple[str, ...]
    wrong: tuple[str, ...]
    claims: tuple[str, ...]


def score(verdict: dict[str, Any] | None, ran: Ran, base: Base, spoiled: Spoiled) -> Score:
    """One run.

    A claim is right if it names what was planted or what the spoil is called, everywhere where that is true. On a
    null whose spoil has a name, silence is "silent" unless a nuisance tells it; with no name to find, quiet is right.
    """
    if verdict is None:
        refused = bool(ran.status == 1 and spoiled.told.refused and re.search(spoiled.told.refused, ran.last))
        outcome, ways = ("refused", ("refusal",)) if refused else ("failed", ())
        return Score(outcome, refused, ways, (), (ran.last,))
    claims = [claim for claim in verdict.get("missing", ()) if claim["effect"] not in base.free]
    planted = {name for one in base.missing for name in (one["effect"], *one.get("accept", ()))}
    true = planted | set(spoiled.names)
    judged = [(claim, _fault(claim, true, base)) for claim in claims]
    wrong = tuple(f"{_name(claim)}{fault}" for claim, fault in judged if fault is not None)
    how = _ways(verdict, claims, spoiled)
    names = tuple(map(_name, claims))
    told = None if not spoiled.text else bool(how)
    if wrong:
        return Score("WRONG", told, how, wrong, names)
    # what is only indicated, or only told in the headline, is no answer where the spoil has a name
    found = bool(set(how) - {"indicated", "headline"})
    wanted = planted or set(spoiled.names)
    return Score(_outcome(claims, wanted, bool(planted), found), told, how, (), names)


def _outcome(claims: list[dict[str, Any]], wanted: set[str], planted: bool, found: bool) -> str:
    if any(claim["effect"] in wanted for claim in claims):
        return "right"
    if any(wanted & set(claim.get("indistinguishable_from", ())) for claim in claims):
        return "set"
    if not wanted:
        return "right"
    return "right" if found and not planted else "silent"


def _fault(claim: dict[str, Any], true: set[str], base: Base) -> str | None:
    """Why a claim is wrong, "" for its name; None if it is not."""
    alike = set(claim.get("indistinguishable_from", ()))
    if claim["effect"] not in true:
        return None if true & alike else ""
    where = claim.get("where", {})
    truth = next((one for one in base.missing if claim["effect"] in (one["effect"], *one.get("accept", ()))), {})
    bounds = {_plain(bound["variable"]) for bound in truth.get("region", ())}
    said = {_plain(bound["variable"]) for bound in where.get("region", ()) or ()}
    if said - bounds:
        return f" only in {', '.join(sorted(said - bounds))}"
    if not bounds and (where.get("recordings") or where.get("frames")):
        return f" only in {', '.join(where.get('recordings') or ['some frames'])}"
    return None


def _ways(verdict: dict[str, Any], claims: Iterable[dict[str, Any]], spoiled: Spoiled) -> tuple[str, ...]:
    """By what the spoil is told; keys of `verdict.json` that an engine does not have yet tell nothing."""
    told, out = spoiled.told, []
    nuisances = verdict.get("nuisances") or {}
    if any(claim["effect"] in spoiled.names for claim in claims):
        out.append("claim")
    if any(claim.get("effect") in spoiled.names for claim in verdict.get("indicated") or ()):
        out.append("indicated")
    if told.pose_factor and _near(nuisances.get("pose_factor"), told.pose_factor):
        out.append("pose_factor")
    if told.shape_rms_m and _near(nuisances.get("shape_rms_m"), told.shape_rms_m):
        out.append("shape_rms_m")
    if told.outliers and {one.get("recording") for one in verdict.get("outliers") or ()} == set(told.outliers):
        out.append("outliers")
    if told.repeats and _joined(verdict.get("repeats") or [], told):
        out.append("repeats")
    headline = str(verdict.get("headline") or "")
    if spoiled.text and re.search(told.words, headline, re.IGNORECASE):
        out.append("headline")
    return tuple(out)


def _joined(found: list[list[str]], told: Told) -> bool:
    return all(any(set(pair) <= set(group) for group in found) for pair in told.repeats)


def _near(value: Any, true: float) -> bool:
    return isinstance(value, int | float) and true / 2 <= value <= 2 * true


def _name(claim: dict[str, Any]) -> str:
    variables = claim.get("where", {}).get("variables", ())
    return f"unknown({','.join(variables)})" if claim["effect"] == "unknown" else str(claim["effect"])


def _plain(name: str) -> str:
    return SAME.get(name, name)
