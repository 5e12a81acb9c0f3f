"""Standing: whether a name stands beside the others, or is only told of as likely."""

from collections.abc import Sequence

from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.extrapolation import Extrapolation
from fusion.discrepancy.naming.judged import Step
from fusion.discrepancy.naming.part import Part
from fusion.discrepancy.naming.refit import Fit
from fusion.discrepancy.naming.step import Found

FAINT_WAVE = 0.003  # of the first gain: one more wave of a named effect that brings less is a matter of its form
FAINT_NAME = 0.02  # of the first gain: less may be the form of a named effect, and is told of as likely
NEARLY_ALL = 0.75  # of all that is left beyond noise: one that explains so much is no matter of form
FORM = 0.01  # of the first gain, a tenth of its size: no law of a catalogue is known better than that
FAINT_REGION = 0.1  # the same for one that acts in a region only, and for a field beside a field
CHANCE = 4.0  # of the chi2 where a part hardly shows: two standard deviations of one number contradict nothing
UNSURE = 1 / 1.645  # of a size: its own interval of 90 % does not tell it from zero
LIKELY = 0.01  # a probability below which an effect is told of, though it is not established


def is_faint(fit: Fit, found: Found) -> bool:
    """True when a further part brings too little to be more than the form of the parts before it."""
    if not fit.parts:
        return False
    most = max(gain_of(part) for part in fit.parts)
    fields = [gain_of(part) for part in fit.parts if part.size]
    if found.part.size and fields:
        return found.gain < FAINT_REGION * max(fields)  # what one field leaves looks like another
    if found.part.candidate.where:
        return found.gain < FAINT_REGION * most
    if any(part.name == found.part.name for part in fit.parts):
        return found.gain < FAINT_WAVE * most
    # what the form of an effect leaves follows no other plain law
    beyond_noise = float(fit.white @ fit.white) - len(fit.white)
    matter_of_form = bool(found.part.size) or found.gain < NEARLY_ALL * beyond_noise
    return found.gain < (FAINT_NAME if matter_of_form else FORM) * most


def contradicted(fit: Fit, beyond: Extrapolation) -> list[int]:
    """Parts that make the recordings held back worse by more than chance and more than a tenth of their size does."""
    chance = CHANCE * inflation(fit.white)
    told = [(k, gain) for k, gain in enumerate(beyond.gains) if gain is not None]
    return [k for k, gain in told if -gain > max(chance, FORM * gain_of(fit.parts[k]))]


def weak_of(steps: Sequence[Step]) -> list[Step]:
    """Steps that do not stand beside the others as they are now.

    Chance makes them, or recordings that took no part in their fit become worse. Beside a first name also those whose
    own interval holds zero, or that are so small that they may be the form of the first.
    """
    bad = [step.held_out < 0 or step.probability > LIKELY for step in steps]
    for k, step in enumerate(steps):
        if step.effect.name != steps[0].effect.name:
            # a size is as open as the shape that it goes with
            bad[k] |= (step.std > UNSURE and not step.shapes_std) or step.gain < FORM * steps[0].gain
    return [step for step, is_bad in zip(steps, bad, strict=True) if is_bad]


def told_of(step: Step) -> Step | None:
    """A step that does not stand is told of where chance is ruled out."""
    return step if step.held_out > 0 and step.probability <= LIKELY else None


def gain_of(part: Part) -> float:
    """Chi2 that a part explains, the others as they are."""
    return float(part.footprint @ part.footprint)
