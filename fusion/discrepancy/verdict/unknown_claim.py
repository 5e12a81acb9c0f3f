"""The claim of an effect that no entry of the catalogue explains: what it depends on, its form, why it has no name."""

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.unknown.unknown import Unknown
from fusion.discrepancy.verdict.claim import Claim, ClaimedNumber, ClaimEvidence, LawForm, Where
from fusion.discrepancy.verdict.sizes import size_in_depth


def unknown_claim(found: Explanation, beyond: Unknown, before: float) -> Claim:
    """An entry of the verdict; `law`, `frame` and `nearest` are what is known of it beside its variables."""
    law, nearest = beyond.law, beyond.nearest
    size = (float((law.native**2).mean())) ** 0.5
    unit = "m" if found.before.patches[0].view.time_of_flight else "px"
    text = f"an effect that no entry of the catalogue explains: {law.text}; {beyond.frame.text}"
    if nearest is not None:
        text += f"; nearest is {nearest.effect}, but {nearest.reason}"
    return Claim(
        effect="unknown",
        parameters={"rms": ClaimedNumber(value=size, std=size * law.std, unit=unit)},
        channel="bias",
        size=size_in_depth(found, law.native),
        where=Where(variables=law.variables, text=text),
        evidence=ClaimEvidence(
            heldout_gain=law.held_out / before,
            false_alarm_probability=law.probability,
            visible_share=found.covariance.visible(law.native),
            posterior=found.posterior,
        ),
        indistinguishable_from=(),
        record_next=_next(law.variables),
        law=LawForm(form=law.text, simple=law.simple),
        frame=beyond.frame,
        nearest=nearest,
    )


def _next(variables: tuple[str, ...]) -> str:
    return (
        f"the same scene with {' and '.join(variables)} beyond the values seen so far and everything else the same: "
        "the form is known only inside them"
    )
