"""The verdict: what an explanation says, as the file that others read (`fusion-verdict/1`)."""

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from fusion.discrepancy.compared import depth_per_native
from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.inference.camera_file import file_error
from fusion.discrepancy.inference.identifiability import visibilities
from fusion.discrepancy.inference.shapes import bent_m, mesh_off
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.assessment import Step
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.outliers import outliers_of
from fusion.discrepancy.observe.placements import repeats_of
from fusion.discrepancy.planning.plan import Plans
from fusion.discrepancy.setting import Explained
from fusion.discrepancy.verdict.channel_claims import channel_claim
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import FORMAT, MODEL, SIMULATION, Nuisances, Verdict
from fusion.discrepancy.verdict.fit import fit_of, unexplained_of
from fusion.discrepancy.verdict.limits import limits_of
from fusion.discrepancy.verdict.mean_claim import mean_claim
from fusion.discrepancy.verdict.record_next import planned_next
from fusion.discrepancy.verdict.reference import reference_of
from fusion.discrepancy.verdict.setting_words import misplaced
from fusion.discrepancy.verdict.unknown_claim import unknown_claim
from fusion.discrepancy.verdict.words import sentence

Vector = NDArray[np.float64]


def verdict_of(found: Explanation) -> Verdict:
    """What an explanation says; names of mask pictures are added by whoever draws them."""
    groups, likely = _by_name(found.named.steps), _by_name(found.named.likely)
    before = float(found.white @ found.white)
    plans = Plans(found.named.sensor, found.blocks)
    missing = [_with_next(mean_claim(steps, found, before), steps, found, plans) for steps in groups]
    missing = _joined(missing, [channel_claim(found, step) for step in found.channels.steps if step.established])
    indicated = [_with_next(mean_claim(steps, found, before), steps, found, plans) for steps in likely]
    indicated += [channel_claim(found, step) for step in found.channels.steps if not step.established]
    if found.beyond is not None:
        (missing if found.unknown else indicated).append(unknown_claim(found, found.beyond, before))
    missing.sort(key=lambda claim: -claim.evidence.heldout_gain)
    named = {name for claim in missing for name in (claim.effect, *claim.indistinguishable_from)}
    named |= {claim.effect for claim in indicated}  # its size is told; a limit would deny it
    visible = visibilities(found.candidates, found.covariance)
    limits, invisible = limits_of(found, visible, named)
    unexplained, nuisances = unexplained_of(found), nuisances_of(found.before, found.covariance, found.white_left)
    outliers = tuple(outliers_of(found.before))
    # a limit is one beside a model that fits, and says nothing beside one that does not
    fits = unexplained.chi2_per_dof <= NOISE_ALONE and not misplaced(nuisances)
    verdict = Verdict(
        format=FORMAT,
        nothing_missing=not missing and fits and not any(outlier.empty for outlier in outliers),
        missing=tuple(missing),
        fit=fit_of(found),
        indicated=tuple(indicated),
        limits=limits if fits else (),
        invisible=invisible,
        identifiability=tuple(visible),
        would_show=tuple(plans.to_show(invisible)),
        unexplained=unexplained,
        nuisances=nuisances,
        nuisances_instead=None if found.rival is None else _instead(found.rival),
        outliers=outliers,
        single_pixels=found.alone,
        repeats=tuple(map(tuple, repeats_of(found.blocks))),
        reference=reference_of(found.before, found.covariance, found.candidates),
        against=SIMULATION if any(block.given is not None for block in found.blocks) else MODEL,
    )
    return replace(verdict, headline=sentence(verdict))


def _with_next(claim: Claim, steps: list[Step], found: Explanation, plans: Plans) -> Claim:
    """A claim with the recording that parts it from its look-alikes."""
    rivals = [name for name in claim.indistinguishable_from if name not in claim.zero_of]  # no recording parts these
    following = planned_next(steps, rivals, found.candidates, plans)
    return claim if following is None else replace(claim, record_next=following.text, next=following)


def _joined(named: list[Claim], others: list[Claim]) -> list[Claim]:
    """All claims; an effect that the mean has named is one with what a channel says of it: its squares, its grain."""
    known = {claim.effect: claim for claim in named}
    for claim in others:
        if (own := known.get(claim.effect)) is None:
            continue
        numbers = dict(own.parameters)
        for label, number in claim.parameters.items():
            value = numbers[label].value if label in numbers else 0.0
            numbers[label] = replace(numbers.get(label, number), value=float(np.hypot(value, number.value)))
        known[claim.effect] = replace(own, parameters=numbers)
    return [*known.values(), *(claim for claim in others if claim.effect not in known)]


def _by_name(steps: Sequence[Step]) -> list[list[Step]]:
    groups: dict[str, list[Step]] = {}
    for step in steps:
        groups.setdefault(step.effect.name, []).append(step)
    return list(groups.values())


def _instead(rival: Explained) -> Nuisances:
    """Sizes of a setting in which no law is missing."""
    before, covariance = rival.observations, rival.covariance
    return nuisances_of(before, covariance, covariance.whiten(before.residual))


def nuisances_of(before: Observations, covariance: TileCovariance, left: Vector) -> Nuisances:
    """Sizes that were found beside what was stated: factor on the errors of poses; shape and drift as depth [m].

    Args:
        left: (n,) what the model leaves, in units of the covariance.
    """
    loose = before.loose
    drift = loose.drift * float(np.sqrt(np.mean(depth_per_native(before) ** 2)))
    pulled = covariance.pulled(left)
    scale, off = mesh_off(before, pulled)
    return Nuisances(
        pose_factor=loose.poses,
        shape_rms_m=bent_m(before, pulled),
        mesh_scale=scale,
        mesh_off_m=off,
        drift_rms_m=drift,
        camera_file=file_error(before, pulled),
    )
