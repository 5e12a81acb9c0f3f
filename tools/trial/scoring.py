"""Scores a verdict against a label, as the readme of the open challenges defines it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import beta

LOOSE = ("amplitude", "rms", "step")  # sizes that are defined in more than one way
POSSIBLE, MARGINAL = 5.0, 3.0  # significance of the oracle


@dataclass(frozen=True)
class Score:
    """Attributes:
    points: 1 right, 0 nothing said, -1 wrong, -2 a claim where nothing is missing; shares for sets.
    outcome: "right", "set", "silent", "unknown", "wrong", "false claim", "quiet" (a null left alone), "failed".
    claimed: the first name.
    recalled, missing: effects that are named anywhere, and effects that are missing.
    variables: share of the true variables that an "unknown" names, None for other answers.
    extra: names that are claimed besides, none of them missing.
    errors: of the parameters that can be compared, in standard deviations that the engine states.
    """

    points: float
    outcome: str
    claimed: str
    recalled: int
    missing: int
    variables: float | None = None
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
    variables = None
    if first["effect"] == "unknown" and "unknown" in right:
        true, said = set(truths[0]["variables"]), set(first["where"]["variables"])
        variables = len(true & said) / max(len(true), 1)
    extra = tuple(sorted(names - right - set(label["equivalent"]) - {first["effect"]}))
    return Score(points, outcome, first["effect"], recalled, len(truths), variables, extra, _errors(claims, truths))


def _named(claim: dict[str, Any], right: set[str], alike: set[str]) -> tuple[float, str]:
    name, said = claim["effect"], {claim["effect"], *claim.get("indistinguishable_from", ())}
    if name == "unknown":
        return (1.0, "right") if "unknown" in right else (0.0, "unknown")
    if alike and len(said) > 1 and said & right and said & alike:
        return 1.0, "set"
    if name in right:
        return 1.0 / (1 + len(alike)), "right"
    return (1.0 / len(said), "set") if said & right else (-1.0, "wrong")


def _errors(claims: list[dict[str, Any]], truths: list[dict[str, Any]]) -> tuple[float, ...]:
    out = []
    for claim in claims:
        true: dict[str, Any] = next((t.get("parameters", {}) for t in truths if t["effect"] == claim["effect"]), {})
        for name, said in claim.get("parameters", {}).items():
            if name in true and name not in LOOSE and said.get("std") and np.ndim(said["value"]) == 0:
                out.append((said["value"] - true[name]["value"]) / said["std"])
    return tuple(out)


def stratum(label: dict[str, Any]) -> str:
    """What someone who knows the form could do."""
    z = label["z_o"]
    if label["nothing_missing"]:
        return "null"
    if z is None:
        return "no bias"
    return "possible" if z >= POSSIBLE else "marginal" if z >= MARGINAL else "impossible"


def interval(hits: int, of: int, level: float = 0.9) -> tuple[float, float]:
    """Exact binomial interval (Clopper and Pearson) of a share."""
    if not of:
        return 0.0, 1.0
    tail = (1 - level) / 2
    low = float(beta.ppf(tail, hits, of - hits + 1)) if hits else 0.0
    return low, float(beta.ppf(1 - tail, hits + 1, of - hits)) if hits < of else 1.0


def table(results: Sequence[dict[str, Any]]) -> str:
    """Families against outcomes, by what the oracle could do, with the interval of the right share."""
    rows: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for result in results:
        rows.setdefault((result["label"]["family"], stratum(result["label"])), []).append(result)
    heads = (
        ("oracle", 12),
        ("n", -4),
        ("right", -7),
        ("set", -5),
        ("unkn.", -6),
        ("silent", -7),
        ("wrong", -6),
        ("extra", -6),
        ("points", -8),
    )
    line = f"{'family':<14}" + "".join(f"{name:<{n}}" if n > 0 else f"{name:>{-n}}" for name, n in heads)
    out = [f"{line}  right or quiet, 90 %"]
    for (family, level), cases in rows.items():
        count = {o: sum(c["score"]["outcome"] == o for c in cases) for o in OUTCOMES}
        good = count["right"] + count["set"] + count["quiet"]
        low, high = interval(good, len(cases))
        bad, mean = count["wrong"] + count["false claim"], sum(c["score"]["points"] for c in cases) / len(cases)
        extra = sum(bool(c["score"]["extra"]) for c in cases)
        numbers = f"{len(cases):>4}{count['right'] + count['quiet']:>7}{count['set']:>5}{count['unknown']:>6}"
        numbers += f"{count['silent'] + count['failed']:>7}{bad:>6}{extra:>6}{mean:>8.2f}"
        out.append(f"{family:<14}{level:<12}{numbers}  {good / len(cases):.2f} [{low:.2f}, {high:.2f}]")
    return "\n".join([*out, _coverage(results)])


def _coverage(results: Sequence[dict[str, Any]]) -> str:
    """How many 90 % intervals of parameters hold the true value."""
    errors = [error for result in results for error in result["score"]["errors"]]
    inside = sum(abs(error) < 1.645 for error in errors)
    low, high = interval(inside, len(errors))
    return f"90 % intervals that hold the true parameter: {inside} of {len(errors)} [{low:.2f}, {high:.2f}]"


OUTCOMES = ("right", "set", "silent", "unknown", "wrong", "false claim", "quiet", "failed")
