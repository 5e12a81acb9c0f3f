"""What to record next, so that look-alikes part and what cannot be seen shows."""

from collections.abc import Sequence

import numpy as np

from fusion.discrepancy.naming.assessment import Step
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.planning.plan import Next, Plans, rivals_of
from fusion.discrepancy.planning.separation import Claimed
from fusion.discrepancy.verdict.claim import NextRecording
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS


def record_next(effect: Effect, alike: Sequence[str]) -> str:
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


def planned_next(
    steps: Sequence[Step], alike: Sequence[str], candidates: Sequence[Candidate], plans: Plans
) -> NextRecording | None:
    """Text and numbers of the recording that parts one name, all its steps, from its look-alikes; None without any."""
    rivals = rivals_of(alike, candidates)
    if not rivals or not plans.all:
        return None
    footprint = np.sum([step.footprint for step in steps], axis=0)
    name = steps[0].effect.name
    own = rivals_of([name], candidates).get(name, [])
    found = plans.to_part(Claimed(steps[0].effect, footprint), rivals, own)
    choice = found.proposal.choice if found.proposal else None
    return NextRecording(
        text=_text(name, found),
        recording=choice.name if choice else "",
        sigma=found.proposal.sigma if found.proposal else None,
        switch=choice is not None and choice.switch,
        minutes=choice.minutes if choice else None,
        parts=found.parted if choice else (),
        leaves=found.left,
    )


def _text(name: str, found: Next) -> str:
    if found.proposal is None:
        return (
            f"nothing on the menu parts {name} from {', '.join(found.left)}: they change the same things in walls, "
            "steps, patches and switches alike"
        )
    text = f"{found.proposal.choice.text}; it parts {name} from {', '.join(found.parted)} by about "
    text += f"{found.proposal.sigma:.0f} times the noise"
    return text + (f"; {', '.join(found.left)} would still look the same" if found.left else "")
