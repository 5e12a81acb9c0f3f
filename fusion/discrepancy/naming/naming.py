"""Naming: which effects, added to the model, explain the residual; each must pay, replicate and fit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.gauge import Gauge
from fusion.discrepancy.look import Look
from fusion.discrepancy.naming.candidates import Candidate
from fusion.discrepancy.naming.step import Step, best_step
from fusion.discrepancy.observations import Observations, observe
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

MOST_STEPS = 6  # waves of one effect count one by one
FAINT_WAVE = 0.003  # of the first gain: one more wave of a named effect that brings less is a matter of its form
MOST_NAMES = 3
FAINT_NAME = 0.02  # of the first gain: less may be the form of a named effect, and is told of as likely
LIKELY = 0.01  # a probability below which an effect is told of, though it is not established


@dataclass(frozen=True)
class Named:
    """What naming found.

    Attributes:
        steps: in the order of finding.
        sensor: the model with all of them.
        observations: under that model.
        white: (n,) what is left, in units of the gauge.
        likely: the next one, that is likely but not established; None when there is none.
    """

    steps: tuple[Step, ...]
    sensor: Sensor
    observations: Observations
    white: Vector
    likely: Step | None = None


def name_effects(
    looks: Sequence[Look], observations: Observations, gauge: Gauge, candidates: Sequence[Candidate]
) -> Named:
    """Add effects one by one while they pass the tests; `candidates` are those of the given model."""
    sensor = observations.sensor
    steps: list[Step] = []
    likely: Step | None = None
    white = gauge.whiten(observations.residual)
    for _ in range(MOST_STEPS):
        # what an effect would change is of first order, and stays while others are added
        step = best_step(candidates, observations, gauge, white)
        if step is None or not step.established:
            likely = step if step is not None and step.probability < LIKELY else None
            break
        if steps and step.effect.name not in {s.effect.name for s in steps} and step.gain < FAINT_NAME * steps[0].gain:
            likely = step
            break
        names = {s.effect.name for s in steps} | {step.effect.name}
        if len(names) > MOST_NAMES:
            break
        known = sensor.effect(step.effect.name)
        if known is not None and steps and step.gain < FAINT_WAVE * steps[0].gain:
            break
        larger = sensor.having(step.effect if known is None else joined(known, step.effect))
        better = observe(larger, looks)
        if len(better.residual) != len(white):
            break
        after = gauge.whiten(better.residual)
        if after @ after > white @ white - 0.5 * step.gain:
            break  # to first order it helped, in full it does not
        sensor, observations, white = larger, better, after
        steps.append(step)
    return Named(tuple(steps), sensor, observations, white, likely)


def joined(own: Effect, more: Effect) -> Effect:
    """Two effects of one kind as one: lists are continued, other sizes added up."""
    about = parameters(own)
    lists = [name for name, p in about.items() if p.kind == "list"]
    values: dict[str, Any] = {}
    if lists and any(np.any(getattr(own, name)) for name in lists):
        values = {name: np.concatenate([np.atleast_1d(getattr(e, name)) for e in (own, more)]) for name in lists}
    for name, p in about.items():
        if name not in values and p.neutral == 0 and name not in lists:
            total = np.asarray(getattr(own, name)) + np.asarray(getattr(more, name))
            values[name] = np.clip(total, p.low, p.high) if np.ndim(total) else float(np.clip(total, p.low, p.high))
    return replace(own, **values)
