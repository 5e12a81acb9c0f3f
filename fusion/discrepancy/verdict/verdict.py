"""The verdict: what an explanation says, as the file that others read (`fusion-verdict/1`)."""

from typing import Any

import numpy as np

from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.extrapolation import extrapolated
from fusion.discrepancy.identifiability import visibilities
from fusion.discrepancy.naming.judged import Step
from fusion.discrepancy.outliers import outliers_of
from fusion.discrepancy.placements import repeats_of
from fusion.discrepancy.planning.plan import Plans
from fusion.discrepancy.verdict.channel_claims import channel_claim
from fusion.discrepancy.verdict.limits import limits_of
from fusion.discrepancy.verdict.mean_claim import mean_claim
from fusion.discrepancy.verdict.nuisances import nuisances_of
from fusion.discrepancy.verdict.record_next import planned_next, shown_next
from fusion.discrepancy.verdict.reference import reference_of
from fusion.discrepancy.verdict.unexplained import unexplained_of
from fusion.discrepancy.verdict.unknown_claim import unknown_claim
from fusion.discrepancy.verdict.words import SIMULATION, sentence

FORMAT = "fusion-verdict/1"


def verdict_of(found: Explanation) -> dict[str, Any]:
    """The content of `verdict.json`; masks are added by whoever writes pictures."""
    groups = _by_name(found)
    before = float(found.white @ found.white)
    plans = Plans(found.named.sensor, found.looks)
    missing = [_with_next(mean_claim(steps, found, before), steps, found, plans) for steps in groups]
    missing += _beside(missing, [channel_claim(found, step) for step in found.channels.steps if step.established])
    likely = [found.named.likely] if found.named.likely else []
    indicated = [_with_next(mean_claim([step], found, before), [step], found, plans) for step in likely]
    indicated += [channel_claim(found, step) for step in found.channels.steps if not step.established]
    if found.beyond is not None:
        (missing if found.unknown else indicated).append(unknown_claim(found, found.beyond, before))
    missing.sort(key=lambda entry: -entry["evidence"]["heldout_gain"])
    named = {name for entry in missing for name in (entry["effect"], *entry["indistinguishable_from"])}
    named |= {entry["effect"] for entry in indicated}  # its size is told; a limit would deny it
    visible = visibilities(found.candidates, found.gauge)
    limits, invisible = limits_of(found, visible, named)
    flight = found.before.patches[0].view.time_of_flight
    reference = reference_of(found.before, found.gauge, found.candidates)
    unexplained = unexplained_of(found)
    verdict: dict[str, Any] = {
        "format": FORMAT,
        "nothing_missing": not missing and unexplained["chi2_per_dof"] <= NOISE_ALONE,
        "missing": missing,
        "fit": {
            "heldout": {key: _number(value) for key, value in found.held_out.items()},
            "extrapolation": [beyond.entry() for beyond in extrapolated(found)],
            "scatter": {"value": found.before.loose.scatter, "unit": "m" if flight else "px"},
            "drift": {"value": found.before.loose.drift, "unit": "m" if flight else "px"},
            "frames_fitted": sum(len(look.frames) for look in found.looks),
            "frames_heldout": sum(len(look.held.frames) for look in found.looks if look.held),
        },
        "indicated": indicated,
        "limits": limits,
        "invisible": invisible,
        "identifiability": [entry.entry() for entry in visible],
        "would_show": shown_next(invisible, plans),
        "unexplained": unexplained,
        "nuisances": nuisances_of(found),
        "outliers": outliers_of(found.before),
        "repeats": repeats_of(found.looks),
        **({"reference": reference} if reference else {}),
        **({"against": SIMULATION} if any(look.given is not None for look in found.looks) else {}),
    }
    return {**verdict, "headline": sentence(verdict)}


def _with_next(entry: dict[str, Any], steps: list[Step], found: Explanation, plans: Plans) -> dict[str, Any]:
    """A claim with the recording that parts it from its look-alikes."""
    following = planned_next(steps, entry["indistinguishable_from"], found.candidates, plans)
    return entry if following is None else {**entry, "record_next": following["text"], "next": following}


def _beside(named: list[dict[str, Any]], others: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Claims of the channels, without those of an effect that the mean has named: its squares and its grain are one."""
    own = {entry["effect"]: entry for entry in named}
    for entry in others:
        for label, number in entry["parameters"].items() if entry["effect"] in own else ():
            known = own[entry["effect"]]["parameters"].setdefault(label, {**number, "value": 0.0})
            known["value"] = float(np.hypot(known["value"], number["value"]))
    return [entry for entry in others if entry["effect"] not in own]


def _by_name(found: Explanation) -> list[list[Step]]:
    groups: dict[str, list[Step]] = {}
    for step in found.named.steps:
        groups.setdefault(step.effect.name, []).append(step)
    return list(groups.values())


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
