"""Limits: how large what was not found could still be, and what this data cannot show at all."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.naming.candidates import Candidate
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters

CONFIDENCE = 0.95
UNSEEN = 0.01  # share of a footprint that must survive poses and known parameters, or it counts as invisible


def limits_of(found: Explanation, named: set[str]) -> tuple[list[dict[str, Any]], list[str]]:
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
