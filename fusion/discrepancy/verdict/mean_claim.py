"""The claim of an effect that changes the mean depth."""

import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.naming.assessment import Step
from fusion.discrepancy.naming.deviations import deviation_of, deviations_of, entry_spread
from fusion.discrepancy.verdict.claim import Claim, ClaimedNumber, ClaimEvidence, Where
from fusion.discrepancy.verdict.claimed import claimed, claimed_list, variables_said
from fusion.discrepancy.verdict.record_next import record_next
from fusion.discrepancy.verdict.sizes import size_in_depth
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters
from fusion.sensor.where import Bound, inside

NEARLY_ALL, SMALL = 0.9, 0.1  # of what a map changes, squared, and of the image: a spot, and no pattern of all pixels


def mean_claim(steps: list[Step], found: Explanation, before: float) -> Claim:
    """An entry of the verdict for one name: all its waves together."""
    first = steps[0]
    fitted = found.named.suggested or found.named.sensor
    effect = fitted.effect(first.effect.name) or first.effect
    where = first.candidate.where
    zeros = sorted({name for step in steps for name in step.zero_of})
    alike = sorted({name for step in steps for name in step.alike} - {*zeros})
    together = steps[0].together if len(steps) == 1 and not set(steps[0].together) & set(alike) else ()
    return Claim(
        effect=effect.name,
        parameters=_parameters(effect, steps),
        channel="bias",
        size=size_in_depth(found, np.sum([s.candidate.columns @ s.weights for s in steps], axis=0)),
        where=_where((*variables_said(effect.variables), *(b.variable for b in where)), first, found),
        evidence=ClaimEvidence(
            heldout_gain=sum(step.held_out for step in steps) / before,
            false_alarm_probability=first.probability,
            visible_share=found.covariance.visible(first.candidate.columns @ first.weights),
            posterior=found.posterior,
        ),
        indistinguishable_from=(*alike, *together, *zeros),
        only_together=tuple(together),
        zero_of=tuple(zeros),
        record_next=record_next(effect, (*alike, *together)),
    )


def _where(variables: tuple[str, ...], step: Step, found: Explanation) -> Where:
    bounds = step.candidate.where or _spot(step, found)
    recordings, frames = _seen_in(bounds, found)
    text = f"{step.effect.name}: {step.effect.formula}"
    return Where(
        variables=tuple(dict.fromkeys(variables)),
        region=tuple(bound.entry() for bound in bounds),
        recordings=recordings,
        frames=frames,
        text=f"{text}; only where {' and '.join(map(_said, bounds))}" if bounds else text,
    )


def _spot(step: Step, found: Explanation) -> tuple[Bound, ...]:
    """Where in the image a map says nearly all that it says, if that is a small part of it; nothing of other laws."""
    if not step.candidate.form.map:
        return ()
    power = np.zeros(found.before.patches[0].depth.shape)
    squares = (step.candidate.columns @ step.weights) ** 2
    for rows, patch in found.before.rows():
        power += np.append(squares[rows] / patch.tiles.pixels, 0.0)[patch.tiles.label]  # of -1: the last
    order = np.argsort(power, axis=None)[::-1]
    least = int(np.searchsorted(np.cumsum(power.flat[order]), NEARLY_ALL * power.sum())) + 1
    bounds = []
    for variable, at in zip("vu", np.unravel_index(order[:least], power.shape), strict=True):
        bounds.append(Bound(variable, float(at.min()), float(at.max())))
    area = np.prod([bound.high - bound.low + 1 for bound in bounds])
    return tuple(bounds) if area <= SMALL * power.size else ()


def _seen_in(bounds: tuple[Bound, ...], found: Explanation) -> tuple[tuple[str, ...] | None, tuple[int, int] | None]:
    """Recordings with anything in a region, and the frames where these are the same in each; None for all."""
    blocks: dict[int, list[tuple[int, ...]]] = {}
    whole: dict[int, list[tuple[int, ...]]] = {}
    names: dict[int, dict[str, None]] = {}
    for patch in (patch for patch in found.before.patches if len(patch.tiles)):
        block = patch.block
        whole.setdefault(block.place, []).append(block.frames)
        path = getattr(getattr(block.stage, "recording", None), "path", None)
        names.setdefault(block.place, {})[path.name if path else f"{block.place}"] = None
        if np.any(inside(bounds, patch.depth, patch.view) & (patch.tiles.label >= 0)):
            blocks.setdefault(block.place, []).append(block.frames)
    spans = {(min(map(min, own)), max(map(max, own))) for own in blocks.values()}
    all_spans = {(min(map(min, own)), max(map(max, own))) for place, own in whole.items() if place in blocks}
    recordings = None if len(blocks) == len(whole) else tuple(name for p in sorted(blocks) for name in names[p])
    frames = spans.pop() if len(spans) == 1 and spans != all_spans else None
    return recordings, frames


def _said(bound: Bound) -> str:
    if np.isinf(bound.high):
        return f"{bound.variable} is {bound.low:.4g} or more"
    if np.isinf(bound.low):
        return f"{bound.variable} is {bound.high:.4g} or less"
    return f"{bound.variable} is {bound.low:.4g} to {bound.high:.4g}"


def _parameters(effect: Effect, steps: list[Step]) -> dict[str, ClaimedNumber]:
    """Fitted values with standard deviation and unit; maps and long lists by what is typical of them."""
    out: dict[str, ClaimedNumber] = {}
    first, spread = steps[0], entry_spread(steps[0])
    summary = effect.summary(spread)
    about_all = parameters(effect)
    sizes = {name for atom in first.candidate.form.atoms for name in atom}
    groups = {about_all[name].group for name in sizes}
    for about in about_all.values():
        value = np.asarray(getattr(effect, about.name), float)
        # what a size refers to is told too: a coefficient without its reference says nothing
        refers = about.neutral != 0 and about.kind in ("number", "scalar") and about.group in groups
        if not np.any(value != about.neutral) and not refers:
            continue
        if about.kind == "map":
            rms = float(np.sqrt(np.mean(value**2)))
            out["rms"] = ClaimedNumber(value=rms, std=rms * first.std, unit=about.unit)
        elif about.kind == "list" and value.ndim:
            if not summary:  # else the list itself stands in the sensor file
                out[about.label] = claimed_list(about, value.ravel(), deviations_of(about, effect, steps))
        else:
            out[about.label] = claimed(about, float(value), deviation_of(about, first))
    for name, (size, unit) in summary.items():
        out[name] = ClaimedNumber(value=size, std=spread, unit=unit)
    return out
