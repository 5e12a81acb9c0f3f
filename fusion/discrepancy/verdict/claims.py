"""Claims: what is said to be missing, as entries of the verdict."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.explain import Explanation, variables_of
from fusion.discrepancy.naming.region import Region, region_of
from fusion.discrepancy.naming.step import Step
from fusion.discrepancy.unknown.unrestricted import Found
from fusion.discrepancy.verdict.record_next import record_next
from fusion.sensor.effect import Effect
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters

# a law of the range or of the disparity is one of the depth too
ALSO = {"range": "depth", "disparity": "depth"}


def mean_claim(steps: list[Step], found: Explanation, before: float) -> dict[str, Any]:
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
        "record_next": record_next(effect, alike),
    }


def unknown_claim(found: Explanation, before: float) -> dict[str, Any]:
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


def _end(value: float) -> float:
    """JSON has no infinity."""
    return float(np.clip(value, -1e9, 1e9))
