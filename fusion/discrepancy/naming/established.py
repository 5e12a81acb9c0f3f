"""Standing: whether a name stands beside the others, or is only told of as likely."""

from collections.abc import Sequence

import numpy as np

from fusion.discrepancy.naming.assessment import Step
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.heterogeneity import form_of
from fusion.discrepancy.naming.refit import PartsFit, refitted
from fusion.discrepancy.naming.search.step import NextPart
from fusion.evaluation.quantization import LEVEL

FAINT_WAVE = 0.003  # of the first gain: one more wave of a named effect that brings less is a matter of its form
FAINT_NAME = 0.02  # of the first gain: less may be the form of a named effect, and is told of as likely
NEARLY_ALL = 0.75  # of all that is left beyond noise: one that explains so much is no matter of form
FAINT_REGION = 0.1  # the same for one that acts in a region only, and for a field beside a field
UNSURE = 1 / LEVEL  # of a size: its own interval of 90 % does not tell it from zero
LIKELY = 0.01  # a probability below which an effect is told of, though it is not established


def is_faint(fit: PartsFit, found: NextPart) -> bool:
    """True when a further part brings too little to be more than the form of the parts before it."""
    if not fit.parts:
        return False
    gains = [gain_of(part) for part in fit.parts]
    most = max(gains)
    fields = [gain_of(part) for part in fit.parts if part.size]
    if found.part.size and fields:
        return found.gain < FAINT_REGION * max(fields)  # what one field leaves looks like another
    if any(part.name == found.part.name for part in fit.parts):
        return found.gain < (FAINT_REGION if found.part.candidate.where else FAINT_WAVE) * most
    form = form_of(fit, int(np.argmax(gains)))
    if found.part.candidate.where:
        return found.gain < max(FAINT_REGION, form) * most
    # what the form of an effect leaves follows no other plain law
    beyond_noise = float(fit.white @ fit.white) - len(fit.white)
    matter_of_form = bool(found.part.size) or beyond_noise <= 0 or found.gain < NEARLY_ALL * beyond_noise
    return found.gain < (max(FAINT_NAME, form) if matter_of_form else form) * most


def weak_of(steps: Sequence[Step]) -> list[Step]:
    """Steps that do not stand beside the others as they are now.

    Chance makes them, or recordings that took no part in their fit become worse; beside a first name, their own
    interval holds zero.
    """
    bad = [step.held_out < 0 or step.probability > LIKELY for step in steps]
    for k, step in enumerate(steps):
        if step.effect.name != steps[0].effect.name:
            bad[k] |= step.std > UNSURE and not step.shapes_std  # a size is as open as the shape that it goes with
    return [step for step, is_bad in zip(steps, bad, strict=True) if is_bad]


def without_faint(fit: PartsFit, steps: Sequence[Step]) -> tuple[PartsFit, Step] | None:
    """The fit without its least name, and that name's first step, where all of it may be the form of the others."""
    names = sorted({step.effect.name for step in steps})
    if len(names) < 2:
        return None
    # whichever was found first
    least = min(names, key=lambda name: sum(step.gain for step in steps if step.effect.name == name))
    step = next(step for step in steps if step.effect.name == least)
    own = next(part for part in fit.parts if part.candidate is step.candidate)
    rest = refitted([part for part in fit.parts if part.name != least], fit.observations, fit.covariance)
    gain = float(rest.white @ rest.white - fit.white @ fit.white)
    return (rest, step) if is_faint(rest, NextPart(own, gain, 0.0, step.held_out, step.probability)) else None


def gain_of(part: EffectPart) -> float:
    """Chi2 that a part explains, the others as they are."""
    return float(part.footprint @ part.footprint)
