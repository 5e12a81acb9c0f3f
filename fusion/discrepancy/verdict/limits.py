"""Limits: how large what was not found could still be, and what this data cannot show at all."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fusion.discrepancy.decisions import CONFIDENCE, SPREAD_FRAMES
from fusion.discrepancy.edges.steps import shown_at_edges
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.inference.identifiability import NOT_SIZES, Identifiability, unseen
from fusion.discrepancy.light.steps import shown_by_light
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.verdict.content import UpperLimit
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters

LEAST_CHANGE = 0.02  # of the spread, or of the share of valid pixels, at the typical size of an effect


def limits_of(
    found: Explanation, seen: Sequence[Identifiability], named: set[str]
) -> tuple[tuple[UpperLimit, ...], tuple[str, ...]]:
    """Upper limits of what was looked for and not found, and the names that this data cannot show.

    Args:
        seen: what the mean depth could show.
        named: names that need no limit, because they are claimed or look like a claim.
    """
    visible = {entry.effect for entry in seen if entry.visible}
    limits: dict[str, UpperLimit] = {}
    for candidate in found.candidates:
        known = candidate.name in named or candidate.name in limits or candidate.where
        if not known and candidate.name in visible and candidate.form.atoms and np.any(candidate.white[:, 0]):
            limits[candidate.name] = _limit(candidate, found.named.white)
    scattered = _in_scatter(found.before) | shown_at_edges(found.before) | shown_by_light(found.before)
    return tuple(limits.values()), tuple(
        name for name in unseen(seen, found.before.sensor.principle) if name not in scattered and name != "tabulated"
    )


def _limit(candidate: Candidate, white: NDArray[np.float64]) -> UpperLimit:
    about = parameters(candidate.form.kind)
    name = next(key for key in candidate.form.atoms[0] if key not in NOT_SIZES)
    column = candidate.white[:, 0]
    power = float(column @ column)
    size = float(np.max(np.abs(np.asarray(candidate.form.atoms[0].get(name, 0.0), float))))
    upper = (abs(float(column @ white)) / power + ndtri(CONFIDENCE) / np.sqrt(power)) * size
    parameter: Parameter = about[name]
    return UpperLimit(
        effect=candidate.name,
        parameter=parameter.label,
        upper=float(upper),
        unit=parameter.unit,
        confidence=CONFIDENCE,
    )


def _in_scatter(observations: Observations) -> set[str]:
    """Names of effects that would show in the scatter of repeated frames or in missing values here."""
    patches = [patch for patch in observations.patches if len(patch.block.frames) >= SPREAD_FRAMES]
    out = {effect.name for effect in observations.sensor.effects if effect.changes("noise") and patches}
    for kind in EFFECTS if patches else ():
        sizes = [p for p in parameters(kind).values() if p.neutral == 0 and p.kind in ("number", "scalar", "list")]
        if kind.frozen or not sizes:
            continue
        size: dict[str, Any] = {sizes[0].name: sizes[0].typical}
        effect = kind(**size)
        if any(_scatters(effect, patch) for patch in patches):
            out.add(kind.name)
    return out


def _scatters(effect: Any, patch: Any) -> bool:
    with np.errstate(all="ignore"):
        if effect.changes("noise") or effect.changes("spread"):
            grown = np.broadcast_to(
                effect.spread(patch.sigma, patch.depth, patch.view) / patch.sigma, patch.depth.shape
            )
            if np.any(np.abs(patch.tiles.mean(grown) - 1) > LEAST_CHANGE):
                return True
        if effect.changes("dropout"):
            lost = np.broadcast_to(effect.dropout(patch.depth, patch.view), patch.depth.shape)
            return bool(np.nanmean(lost) > LEAST_CHANGE)
    return False
