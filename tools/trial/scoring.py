"""Scores a verdict against a label, as the readme of the open challenges defines it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import beta

LOOSE = ("amplitude", "rms", "step")  # sizes that are defined in more than one way
# the same thing said in another way
SAME = {"range": "depth", "disparity": "depth", "material": "reflectance", "temperature": "time"}
POSSIBLE, MARGINAL = 5.0, 3.0  # significance of the oracle


@dataclass(frozen=True)
class Score:
    """Attributes:
    points: 1 right, 0 nothing said, -1 wrong, -2 a claim where nothing is missing; shares for sets.
    outcome: "right", "set", "silent", "unknown", "wrong", "false claim", "quiet" (a null left alone), "failed".
    claimed: the first name.
    recalled, missing: effects that are named anywhere, and effects that are missing.
    variables: F1 of the variables that an "unknown" names, None for other answers.
    region: whether the variable that bounds a partial effect is named, None where nothing is partial.
    extra: names that are claimed besides, none of them missing.
    errors: of the parameters that can be compared, in standard deviations that the engine states.
    """

    points: float
    outcome: str
    claimed: str
    recalled: int
    missing: int
    variables: float | None = None
    region: bool | None = None
    extra: tuple[str, ...] = ()
    errors: tuple[float, ...] = ()


def score(verdict: dict[str, Any] | None, label: dict[str, Any]) -> Score:
    """One case."""
    truths = label["missing"]
    if verdict is None:
        return Score(0.0, "failed", "", 0, len(truths))
    free = set(label.get("known_truth", {}))
    claims = [claim for claim in verdict["missing"] if claim["effect"] not in free]
    names = {claim["effect"] for claim in claims}
    right = {name for truth in truths for name in (truth["effect"], *truth["accept"])}
    recalled = sum(bool(names & {t["effect"], *t["accept"]}) for t in truths)
    if not truths:
        false = [c["effect"] for c in claims if c["effect"] not in label["accept_on_null"]]
        return Score(-2.0, "false claim", false[0], 0, 0) if false else Score(0.0, "quiet", "", 0, 0)
    if not claims:
        return Score(0.0, "silent", "", 0, len(truths))
    first = claims[0]
    points, outcome = _named(first, right, set(label["equivalent"]))
    variables = region = None
    if first["effect"] == "unknown" and "unknown" in right:
        variables = likeness(truths[0]["variables"], first["where"]["variables"])
    if truths[0].get("region"):
        bounds = {_plain(bound["variable"]) for bound in first["where"].get("region", ())}
        region = bool(bounds & {_plain(bound["variable"]) for bound in truths[0]["region"]})
    extra = tuple(sorted(names - right - set(label["equivalent"]) - {first["effect"]}))
    errors = _errors(verdict["missing"], truths, label.get("known_truth", {}))
    return Score(points, outcome, first["effect"], recalled, len(truths), variables, region, extra, errors)


def likeness(true: Sequence[str], said: Sequence[str]) -> float:
    """F1 of the variables said; u and v together say as much as the radius."""
    wanted, named = {_plain(name) for name in true}, {_plain(name) for name in said}
    if "radius" in wanted and {"u", "v"} <= named:
        named = (named - {"u", "v"}) | {"radius"}
    return 2 * len(wanted & named) / max(len(wanted) + len(named), 1)


def _plain(name: str) -> str:
    return SAME.get(name, name)


def _named(claim: dict[str, Any], right: set[str], alike: set[str]) -> tuple[float, str]:
    name, said = claim["effect"], {claim["effect"], *claim.get("indistinguishable_from", ())}
    if name == "unknown":
        return (1.0, "right") if "unknown" in right else (0.0, "unknown")
    if alike and len(said) > 1 and said & right and said & alike:
        return 1.0, "set"
    if name in right:
        return 1.0 / (1 + len(alike)), "right"
    return (1.0 / len(said), "set") if said & right else (-1.0, "wrong")


def _errors(claims: list[dict[str, Any]], truths: list[dict[str, Any]], known: dict[str, Any]) -> tuple[float, ...]:
    true = {(t["effect"], name): p["value"] for t in truths for name, p in t.get("parameters", {}).items()}
    true |= {(name, "offset"): about["true"] for name, about in known.items() if "true" in about}
    out = []
    for claim in claims:
        for name, said in claim.get("parameters", {}).items():
            value = true.get((claim["effect"], name))
            if value is not None and name not in LOOSE and said.get("std") and np.ndim(said["value"]) == 0:
                out.append((said["value"] - value) / said["std"])
    return tuple(out)


def stratum(label: dict[str, Any]) -> str:
    """What someone who knows the form could do."""
    z = label["z_o"]
    if label["nothing_missing"]:
        return "null"
    if z is None:
        return "not asked"
    return "possible" if z >= POSSIBLE else "marginal" if z >= MARGINAL else "impossible"


def interval(hits: int, of: int, level: float = 0.95) -> tuple[float, float]:
    """Exact binomial interval (Clopper and Pearson) of a share."""
    if not of:
        return 0.0, 1.0
    tail = (1 - level) / 2
    low = float(beta.ppf(tail, hits, of - hits + 1)) if hits else 0.0
    return low, float(beta.ppf(1 - tail, hits + 1, of - hits)) if hits < of else 1.0
