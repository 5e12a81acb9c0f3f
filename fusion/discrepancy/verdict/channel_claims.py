"""Claims of the channels beside the mean: noise and missing values."""

from typing import Any

import numpy as np

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claimed import claimed, variables_said
from fusion.discrepancy.verdict.record_next import record_next
from fusion.discrepancy.verdict.sizes import size_of_step
from fusion.sensor.parameter import parameters

OF = {"noise": "the spread of repeated frames", "dropout": "missing values"}


def channel_claim(found: Explanation, step: ChannelStep) -> dict[str, Any]:
    """A finding of a channel as an entry of the verdict."""
    return {
        "effect": step.effect.name if step.effect else "unknown",
        "parameters": _parameters(step),
        "channel": step.channel,
        "size": size_of_step(found, step),
        "where": {
            "variables": _variables(step),
            "region": [],
            "recordings": None,
            "frames": None,
            "mask": None,
            "text": _text(step),
        },
        "evidence": {
            "heldout_gain": step.share,
            "false_alarm_probability": step.probability,
            "visible_share": 1.0,
        },
        "indistinguishable_from": list(step.alike),
        "record_next": record_next(step.effect, list(step.alike)) if step.effect else "",
        **({"law": {"form": step.form, "simple": False, "added_as": "tabulated"}} if step.form else {}),
    }


def _variables(step: ChannelStep) -> list[str]:
    names = step.variables or (step.effect.variables if step.effect else ())
    return variables_said(names)


def _text(step: ChannelStep) -> str:
    said = step.text
    if not said and step.effect is not None:
        said = "as the model has it, with other numbers" if step.corrected else step.effect.formula
    return f"{OF[step.channel]}: {said}" if step.channel in OF else said


def _parameters(step: ChannelStep) -> dict[str, Any]:
    if step.effect is None:
        return {}
    about = parameters(step.effect)
    return {
        about[name].label: claimed(about[name], float(np.mean(getattr(step.effect, name))), std)
        for name, std in step.std.items()
    }
