"""The verdict: what an explanation says, as the file that others read (`fusion-verdict/1`)."""

from typing import Any

import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.naming.step import Step
from fusion.discrepancy.verdict.channel_claims import channel_claim
from fusion.discrepancy.verdict.claims import mean_claim, unknown_claim
from fusion.discrepancy.verdict.limits import limits_of

FORMAT = "fusion-verdict/1"


def verdict_of(found: Explanation) -> dict[str, Any]:
    """The content of `verdict.json`; masks are added by whoever writes pictures."""
    groups = _by_name(found)
    before = float(found.white @ found.white)
    missing = [mean_claim(steps, found, before) for steps in groups]
    missing += [channel_claim(step) for step in found.channels.steps]
    if found.unknown:
        missing.append(unknown_claim(found, before))
    missing.sort(key=lambda entry: -entry["evidence"]["heldout_gain"])
    named = {name for entry in missing for name in (entry["effect"], *entry["indistinguishable_from"])}
    limits, invisible = limits_of(found, named)
    return {
        "format": FORMAT,
        "nothing_missing": not missing,
        "missing": missing,
        "fit": {
            "heldout": {key: _number(value) for key, value in found.held_out.items()},
            "frames_fitted": sum(len(look.frames) for look in found.looks),
            "frames_heldout": sum(len(look.held.frames) for look in found.looks if look.held),
        },
        "indicated": [mean_claim([found.named.likely], found, before)] if found.named.likely else [],
        "limits": limits,
        "invisible": invisible,
    }


def sentence(verdict: dict[str, Any]) -> str:
    """The verdict in one sentence for a person."""
    missing = verdict["missing"]
    if not missing:
        return (
            "Nothing is missing: the model explains these recordings; "
            f"{len(verdict['limits'])} effects were looked for, {len(verdict['invisible'])} cannot be seen here."
        )
    names = [
        f"an unknown effect that depends on {', '.join(entry['where']['variables'])}"
        if entry["effect"] == "unknown"
        else entry["effect"]
        + (f" (or {', '.join(entry['indistinguishable_from'])})" if entry["indistinguishable_from"] else "")
        for entry in missing
    ]
    return "Missing in the model: " + "; ".join(names) + "."


def _by_name(found: Explanation) -> list[list[Step]]:
    groups: dict[str, list[Step]] = {}
    for step in found.named.steps:
        groups.setdefault(step.effect.name, []).append(step)
    return list(groups.values())


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
