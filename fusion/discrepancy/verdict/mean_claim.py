"""The claim of an effect that changes the mean depth."""

from typing import Any

import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.naming.judged import Step
from fusion.discrepancy.naming.part import FIELD
from fusion.discrepancy.verdict.record_next import record_next
from fusion.sensor.effect import Effect
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.where import Bound, inside

# a law of the range or of the disparity is one of the depth too
ALSO = {"range": "depth", "disparity": "depth"}


def mean_claim(steps: list[Step], found: Explanation, before: float) -> dict[str, Any]:
    """An entry of the verdict for one name: all its waves together."""
    first = steps[0]
    effect = found.named.sensor.effect(first.effect.name) or first.effect
    where = first.candidate.where
    laws = [v for name in effect.variables for v in (name, *_also(name))]
    alike = sorted({name for step in steps for name in step.alike})
    together = steps[0].together if len(steps) == 1 and not set(steps[0].together) & set(alike) else ()
    return {
        "effect": effect.name,
        "parameters": _parameters(effect, first),
        "channel": "bias",
        "where": _where(list(dict.fromkeys([*laws, *(b.variable for b in where)])), first, found),
        "evidence": {
            "heldout_gain": sum(step.held_out for step in steps) / before,
            "false_alarm_probability": first.probability,
            "visible_share": found.gauge.visible(first.candidate.columns @ first.weights),
        },
        "indistinguishable_from": [*alike, *together],
        **({"only_together": list(together)} if together else {}),
        "record_next": record_next(effect, [*alike, *together]),
    }


def _where(variables: list[str], step: Step, found: Explanation) -> dict[str, Any]:
    bounds = step.candidate.where
    recordings, frames = _seen_in(bounds, found)
    text = f"{step.effect.name}: {step.effect.formula}"
    return {
        "variables": variables,
        "region": [bound.entry() for bound in bounds],
        "recordings": recordings,
        "frames": frames,
        "mask": None,
        "text": f"{text}; only where {' and '.join(map(_said, bounds))}" if bounds else text,
    }


def _seen_in(bounds: tuple[Bound, ...], found: Explanation) -> tuple[list[str] | None, list[int] | None]:
    """Recordings with anything in a region, and the frames where these are the same in each; None for all."""
    looks: dict[int, list[tuple[int, ...]]] = {}
    whole: dict[int, list[tuple[int, ...]]] = {}
    names: dict[int, str] = {}
    for patch in found.before.patches:
        look = patch.look
        whole.setdefault(look.place, []).append(look.frames)
        names[look.place] = getattr(getattr(look.stage, "recording", None), "path", None) or f"{look.place}"
        if np.any(inside(bounds, patch.depth, patch.view) & (patch.tiles.label >= 0)):
            looks.setdefault(look.place, []).append(look.frames)
    spans = {(min(map(min, own)), max(map(max, own))) for own in looks.values()}
    all_spans = {(min(map(min, own)), max(map(max, own))) for place, own in whole.items() if place in looks}
    recordings = None if len(looks) == len(whole) else [getattr(names[p], "name", names[p]) for p in sorted(looks)]
    frames = list(spans.pop()) if len(spans) == 1 and spans != all_spans else None
    return recordings, frames


def _said(bound: Bound) -> str:
    if np.isinf(bound.high):
        return f"{bound.variable} is {bound.low:.4g} or more"
    if np.isinf(bound.low):
        return f"{bound.variable} is {bound.high:.4g} or less"
    return f"{bound.variable} is {bound.low:.4g} to {bound.high:.4g}"


def _also(name: str) -> tuple[str, ...]:
    return (ALSO[name],) if name in ALSO else ()


def _parameters(effect: Effect, step: Step) -> dict[str, Any]:
    """Fitted values with standard deviation and unit; maps and long lists by what is typical of them."""
    out: dict[str, Any] = {}
    summary = effect.summary(_entry_spread(step))
    about_all = parameters(effect)
    sizes = {name for atom in step.candidate.form.atoms for name in atom}
    groups = {about_all[name].group for name in sizes}
    for about in about_all.values():
        value = np.asarray(getattr(effect, about.name), float)
        # what a size refers to is told too: a coefficient without its reference says nothing
        refers = about.neutral != 0 and about.kind in ("number", "scalar") and about.group in groups
        if not np.any(value != about.neutral) and not refers:
            continue
        if about.kind == "map":
            out["rms"] = _value(float(np.sqrt(np.mean(value**2))), step.std, about.unit)
        elif about.kind == "list" and value.ndim:
            if not summary:  # else the list itself stands in the sensor file
                out[about.label] = {"value": float(value.flat[0]), "std": _std(about, step), "unit": about.unit}
                out[about.label]["all"] = value.ravel().tolist()
        else:
            out[about.label] = {"value": float(value), "std": _std(about, step), "unit": about.unit}
    for name, (size, unit) in summary.items():
        out[name] = {"value": size, "std": _entry_spread(step), "unit": unit}
    return out


def _entry_spread(step: Step) -> float:
    """Usual standard deviation of one entry of a list that was fitted atom by atom; 0 for a form without."""
    form = step.candidate.form
    if form.map or len(step.weights) < FIELD:
        return 0.0
    ones = np.ones(len(step.weights))
    once, twice = form.combined(list(ones)), form.combined(list(2 * ones))
    # what a weight scales, and not where its entry lies
    per_weight = [
        np.abs(np.asarray(getattr(twice, name)) - np.asarray(getattr(once, name))) for name in parameters(form.kind)
    ]
    sizes = [float(np.median(size)) for size in per_weight if np.ndim(size) and np.any(size)]
    return float(np.median(step.weights_std)) * sizes[0] if sizes else 0.0


def _std(about: Parameter, step: Step) -> float | None:
    """Standard deviation of one parameter of a step; None for one that was not fitted."""
    if about.name in step.shapes_std:
        return step.shapes_std[about.name]
    atoms = step.candidate.form.atoms
    for atom, spread in zip(atoms, step.weights_std, strict=True):
        if about.name in atom and about.name not in ANGLES:
            return float(spread) * float(np.max(np.abs(atom[about.name])))
    return step.std if about.name in ANGLES else None  # of a small angle: across over along


def _value(value: float, relative: float, unit: str) -> dict[str, Any]:
    return {"value": value, "std": abs(value) * relative, "unit": unit}
