"""The verdict: what an explanation says, as the file that others read (`fusion-verdict/1`)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from fusion.discrepancy.candidates import Candidate
from fusion.discrepancy.explain import Explanation, variables_of
from fusion.discrepancy.naming import Step
from fusion.discrepancy.region import Region, region_of
from fusion.discrepancy.spread import SpreadStep
from fusion.discrepancy.unrestricted import Found
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters

FORMAT = "fusion-verdict/1"
CONFIDENCE = 0.95
UNSEEN = 0.01  # share of a footprint that must survive poses and known parameters, or it counts as invisible
# a law of the range or of the disparity is one of the depth too
ALSO = {"range": "depth", "disparity": "depth"}


def verdict_of(found: Explanation) -> dict[str, Any]:
    """The content of `verdict.json`; masks are added by whoever writes pictures."""
    groups = _by_name(found)
    before = float(found.white @ found.white)
    missing = [_missing(steps, found, before) for steps in groups]
    if found.spread is not None:
        missing.append(_noise(found.spread))
    if found.unknown:
        missing.append(_unknown(found, before))
    missing.sort(key=lambda entry: -entry["evidence"]["heldout_gain"])
    named = {name for entry in missing for name in (entry["effect"], *entry["indistinguishable_from"])}
    limits, invisible = _limits(found, named)
    return {
        "format": FORMAT,
        "nothing_missing": not missing,
        "missing": missing,
        "fit": {
            "heldout": {key: _number(value) for key, value in found.held_out.items()},
            "frames_fitted": sum(len(look.frames) for look in found.looks),
            "frames_heldout": sum(len(look.held.frames) for look in found.looks if look.held),
        },
        "indicated": [_missing([found.named.likely], found, before)] if found.named.likely else [],
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


def _missing(steps: list[Step], found: Explanation, before: float) -> dict[str, Any]:
    first = steps[0]
    effect = found.named.sensor.effect(first.effect.name) or first.effect
    region = region_of(first.white_before, first.footprint, variables_of(found.before))
    variables = list(dict.fromkeys(v for name in effect.variables for v in (name, *_also(name))))
    if region is not None and region.variable not in variables:
        variables.append(region.variable)
    alike = sorted({name for step in steps for name in step.alike})
    return {
        "effect": effect.name,
        "parameters": _parameters(effect, first),
        "channel": "bias",
        "where": _where(variables, region, f"{effect.name}: {effect.formula}"),
        "evidence": {
            "heldout_gain": sum(step.held_out for step in steps) / before,
            "false_alarm_probability": first.probability,
            "visible_share": found.gauge.visible(first.candidate.columns @ first.weights),
        },
        "indistinguishable_from": alike,
        "record_next": _record_next(effect, alike),
    }


def _noise(step: SpreadStep) -> dict[str, Any]:
    effect, about = step.effect, step.parameter
    variables = list(dict.fromkeys(v for name in effect.variables for v in (name, *_also(name))))
    value = {"value": float(getattr(effect, about.name)), "std": step.std, "unit": about.unit}
    return {
        "effect": effect.name,
        "parameters": {about.label: value},
        "channel": "noise",
        "where": _where(variables, None, f"the spread of repeated frames: {effect.formula}"),
        "evidence": {
            "heldout_gain": step.share,
            "false_alarm_probability": step.probability,
            "visible_share": 1.0,
        },
        "indistinguishable_from": list(step.alike),
        "record_next": _record_next(effect, list(step.alike)),
    }


def _unknown(found: Explanation, before: float) -> dict[str, Any]:
    left: Found = found.left
    variables = list(left.variables) or ["u", "v"]
    nearest = _nearest(found)
    text = (
        f"an effect that no entry of the catalogue explains; it depends on {', '.join(variables)}; nearest: {nearest}"
    )
    return {
        "effect": "unknown",
        "parameters": {},
        "channel": "bias",
        "where": _where(variables, None, text),
        "evidence": {
            "heldout_gain": left.gain / before,
            "false_alarm_probability": float(np.exp(-0.5 * min(left.gain, 1400.0))),
            "visible_share": 1.0,
        },
        "indistinguishable_from": [],
        "record_next": f"the same scene with other {variables[0]}, everything else the same",
    }


def _nearest(found: Explanation) -> str:
    """The catalogue's entry whose footprint is most like the leftover, and how alike."""
    left = found.left.fitted
    length = max(float(np.linalg.norm(left)), 1e-300)
    best = max(found.candidates, key=lambda c: float(np.linalg.norm(c.basis.T @ left)), default=None)
    if best is None:
        return "none"
    return f"{best.name} (cosine {float(np.linalg.norm(best.basis.T @ left)) / length:.2f})"


def _where(variables: list[str], region: Region | None, text: str) -> dict[str, Any]:
    bounds = (
        [] if region is None else [{"variable": region.variable, "low": _end(region.low), "high": _end(region.high)}]
    )
    return {
        "variables": variables,
        "region": bounds,
        "recordings": None,
        "frames": None,
        "mask": None,
        "text": text if region is None else f"{text}; only where {_said(region)}",
    }


def _said(region: Region) -> str:
    if np.isinf(region.high):
        return f"{region.variable} is {region.low:.4g} or more"
    return f"{region.variable} is {region.high:.4g} or less"


def _also(name: str) -> tuple[str, ...]:
    return (ALSO[name],) if name in ALSO else ()


def _parameters(effect: Effect, step: Step) -> dict[str, Any]:
    """Fitted values with standard deviation and unit; maps and bands by their typical size."""
    out: dict[str, Any] = {}
    for about in parameters(effect).values():
        value = np.asarray(getattr(effect, about.name), float)
        if not np.any(value != about.neutral):
            continue
        if about.kind == "map":
            out["rms"] = _value(float(np.sqrt(np.mean(value**2))), step.std, about.unit)
        elif about.kind == "list" and value.ndim:
            if about.name not in ("columns", "steps"):  # where bands lie stands in the sensor file
                out[about.label] = {"value": float(value.flat[0]), "std": _std(about, step), "unit": about.unit}
                out[about.label]["all"] = value.ravel().tolist()
        else:
            out[about.label] = {"value": float(value), "std": _std(about, step), "unit": about.unit}
    if "steps" in parameters(effect) and np.ndim(getattr(effect, "steps", 0.0)):
        out["step"] = _band(np.asarray(getattr(effect, "steps", 0.0), float), step)
    return out


def _band(steps: NDArray[np.float64], step: Step) -> dict[str, Any]:
    """Typical jump between bands: what stands at neighbouring columns is one jump, and noise is none."""
    spread = float(np.median(step.weights_std)) * abs(float(step.candidate.form.atoms[0]["steps"][0]))
    jumps: list[float] = []
    last = -2
    for place in np.flatnonzero(np.abs(steps) > 4 * spread):
        if place == last + 1 and jumps and np.sign(jumps[-1]) == np.sign(steps[place]):
            jumps[-1] += float(steps[place])
        else:
            jumps.append(float(steps[place]))
        last = int(place)
    sizes = np.abs(jumps) if jumps else np.abs(steps)
    return {"value": float(np.sqrt(np.mean(sizes**2))), "std": spread, "unit": "px"}


def _std(about: Parameter, step: Step) -> float | None:
    """Standard deviation of one parameter of a step; None for a shape that was searched, not fitted."""
    atoms = step.candidate.form.atoms
    for atom, spread in zip(atoms, step.weights_std, strict=True):
        if about.name in atom and about.name not in ANGLES:
            return float(spread) * float(np.max(np.abs(atom[about.name])))
    return step.std if about.name in ANGLES else None  # of a small angle: across over along


def _value(value: float, relative: float, unit: str) -> dict[str, Any]:
    return {"value": value, "std": abs(value) * relative, "unit": unit}


def _record_next(effect: Effect, alike: list[str]) -> str:
    """What to vary so that look-alikes part: the variables that one of them has and the other has not."""
    if not alike:
        return ""
    kinds = {kind.name: kind for kind in EFFECTS}
    other = kinds.get(alike[0])
    own = set(effect.variables) ^ set(other.variables if other else ())
    vary = ", ".join(sorted(own)) or ", ".join(effect.variables)
    return (
        f"the same target with other values of {vary} and nothing else changed: {effect.name} and {alike[0]} part there"
    )


def _limits(found: Explanation, named: set[str]) -> tuple[list[dict[str, Any]], list[str]]:
    """Upper limits of what was looked for and not found, and the names that this data cannot show."""
    limits, seen = {}, set()
    for candidate in found.candidates:
        white = candidate.white
        visible = found.gauge.visible(candidate.columns[:, 0])
        if visible < UNSEEN or not np.any(white):
            continue
        seen.add(candidate.name)
        if candidate.name not in named and candidate.form.atoms:
            entry = _limit(candidate, found.named.white)
            if candidate.name not in limits:
                limits[candidate.name] = entry
    invisible = [
        kind.name for kind in EFFECTS if kind.name not in seen and _could_be(kind, found.before.sensor.principle)
    ]
    return list(limits.values()), invisible


def _limit(candidate: Candidate, white: NDArray[np.float64]) -> dict[str, Any]:
    about = parameters(candidate.form.kind)
    name = next(key for key in candidate.form.atoms[0] if key not in (*ANGLES, "columns"))
    column = candidate.white[:, 0]
    power = float(column @ column)
    size = float(np.max(np.abs(np.asarray(candidate.form.atoms[0].get(name, 0.0), float))))
    upper = (abs(float(column @ white)) / power + norm.isf(1 - CONFIDENCE) / np.sqrt(power)) * size
    parameter: Parameter = about[name]
    return {
        "effect": candidate.name,
        "parameter": parameter.label,
        "upper": upper,
        "unit": parameter.unit,
        "confidence": CONFIDENCE,
    }


def _could_be(kind: type[Effect], principle: str) -> bool:
    return not kind.principles or principle in kind.principles


def _end(value: float) -> float:
    """JSON has no infinity."""
    return float(np.clip(value, -1e9, 1e9))


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
