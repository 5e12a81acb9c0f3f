"""Claims of the channels beside the mean: noise and missing values."""

import numpy as np

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.edges.steps import edges_next
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim, ClaimedNumber, ClaimEvidence, LawForm, Where
from fusion.discrepancy.verdict.claimed import claimed, variables_said
from fusion.discrepancy.verdict.record_next import record_next
from fusion.discrepancy.verdict.sizes import size_of_step
from fusion.discrepancy.verdict.words import AT_EDGES, LIGHT
from fusion.sensor.parameter import parameters

OF = {"noise": "the spread of repeated frames", "dropout": "missing values", "edges": AT_EDGES,
      "amplitude": LIGHT}  # fmt: skip
# of a finding at edges it is the mean depth there; with the light it is noise that grows
CHANNELS = {"edges": "bias", "amplitude": "noise"}


def channel_claim(found: Explanation, step: ChannelStep) -> Claim:
    """A finding of a channel as an entry of the verdict."""
    return Claim(
        effect=step.effect.name if step.effect else "unknown",
        parameters=_parameters(step),
        channel=CHANNELS.get(step.channel, step.channel),
        size=size_of_step(found, step),
        where=Where(variables=_variables(step), text=_text(step)),
        evidence=ClaimEvidence(
            heldout_gain=step.share,
            false_alarm_probability=step.probability,
            visible_share=1.0,
            posterior=step.posterior,
        ),
        indistinguishable_from=step.alike,
        record_next=_next(found, step),
        law=LawForm(form=step.form, simple=False) if step.form else None,
    )


def _next(found: Explanation, step: ChannelStep) -> str:
    if step.effect is None:
        return ""
    return edges_next(found.before, step) if step.channel == "edges" else record_next(step.effect, step.alike)


def _variables(step: ChannelStep) -> tuple[str, ...]:
    names = step.variables or (step.effect.variables if step.effect else ())
    return variables_said(names)


def _text(step: ChannelStep) -> str:
    said = step.text
    if not said and step.effect is not None:
        said = "as the model has it, with other numbers" if step.corrected else step.effect.formula
    return f"{OF[step.channel]}: {said}" if step.channel in OF else said


def _parameters(step: ChannelStep) -> dict[str, ClaimedNumber]:
    if step.effect is None:
        return {}
    about = parameters(step.effect)
    return {
        about[name].label: claimed(about[name], float(np.mean(getattr(step.effect, name))), std)
        for name, std in step.std.items()
    }
