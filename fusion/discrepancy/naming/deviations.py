"""Deviations: how well each number of a named effect is known, one for every wave of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.assessment import Step
from fusion.discrepancy.naming.effect_part import FIELD
from fusion.sensor.effect import Effect
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]


def with_deviations(sensor: Sensor, steps: Sequence[Step]) -> Sensor:
    """The model with the standard deviation of every number that the steps fitted, in the shape of its value.

    The numbers of an effect were found together: the correction undoes them whole, however badly one is known alone.
    """
    std, names = dict(sensor.std), {step.effect.name for step in steps}
    for effect in (effect for effect in sensor.effects if effect.name in names):
        own = [step for step in steps if step.effect.name == effect.name]
        for about in parameters(effect).values():
            key = (effect.name, about.name)
            value = np.asarray(getattr(effect, about.name))
            if about.kind == "list" and value.ndim:
                spread = deviations_of(about, effect, own)
                std.pop(key, None)  # of as many as there were before
                if np.isfinite(spread).all():
                    std[key] = tuple(spread.tolist())
            elif value.ndim == 0 and (known := deviation_of(about, own[0])) is not None:
                std[key] = known
    return replace(sensor, std=std, fitted=sensor.fitted | names)


def deviation_of(about: Parameter, step: Step) -> float | None:
    """Standard deviation of one parameter of a step; None for one that was not fitted."""
    if about.name in step.shapes_std:
        return step.shapes_std[about.name]
    atoms = step.candidate.form.atoms
    if len(atoms) != len(step.weights_std):  # a map's weights belong to places of the image, to no parameter
        return None
    for atom, spread in zip(atoms, step.weights_std, strict=True):
        if about.name in atom and about.name not in ANGLES:
            return float(spread) * float(np.max(np.abs(atom[about.name])))
    return step.std if about.name in ANGLES else None  # of a small angle: across over along


def deviations_of(about: Parameter, effect: Effect, steps: Sequence[Step]) -> Vector:
    """(k,) standard deviations of a list, each from the step that found it; NaN for what no step has found."""
    values = np.atleast_1d(np.asarray(getattr(effect, about.name), float))
    out = np.full(len(values), np.nan)
    for step in steps:
        found = np.atleast_1d(np.asarray(getattr(step.effect, about.name), float))
        spread = _of_list(about, step, len(found))
        # a step's entries stand in the list one after the other, wherever it was joined
        for start in range(len(values) - len(found) + 1):
            if np.array_equal(values[start : start + len(found)], found):
                out[start : start + len(found)] = spread
                break
    return out


def _of_list(about: Parameter, step: Step, length: int) -> Vector:
    """(length,) of the entries of one step: how far each moves when the weights do, one by one."""
    if length == 1:
        known = deviation_of(about, step)
        return np.array([np.nan if known is None else known])
    form, variance = step.candidate.form, np.zeros(length)
    start = np.asarray(getattr(form.combined(list(step.weights)), about.name), float)
    for k, spread in enumerate(step.weights_std):
        moved = step.weights.copy()
        moved[k] += spread
        by = np.asarray(getattr(form.combined(list(moved)), about.name), float) - start
        variance += (np.angle(np.exp(1j * by)) if about.name in ANGLES else by) ** 2
    return np.sqrt(variance)


def entry_spread(step: Step) -> float:
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
