"""Competing: laws against a setting that is only worse than stated, all of them together and each beside the others."""

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from itertools import combinations

import numpy as np

from fusion.discrepancy.decisions import CONFIDENCE, LARGEST_SET, SURE
from fusion.discrepancy.inference.scatter import spanned
from fusion.discrepancy.mean import MeanFindings, MeasuredForms, explained_mean, likeliest
from fusion.discrepancy.naming.effect_part import EffectPart, is_field
from fusion.discrepancy.naming.heterogeneity import FORM
from fusion.discrepancy.naming.refit import partial_residual, refitted
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import Scored
from fusion.discrepancy.naming.search.step import scores
from fusion.discrepancy.observe.likely_pose import at_likely_poses
from fusion.discrepancy.setting import Explained, posterior, setting_parts, with_laws, without_laws
from fusion.sensor.sensor import Sensor


def in_likeliest_errors(ways: Sequence[MeasuredForms], sensor: Sensor) -> MeanFindings:
    """What the mean depth says, of errors as stated and ones that fit better the likelier way.

    As stated it is not asked for where all laws there are, and everything smooth, could not make it the likelier one.
    """
    stated, found = ways[0], explained_mean(ways[-1], sensor)
    if len(ways) == 1:
        return found
    basis = spanned(stated.candidates, stated.groups)
    if basis is not None:
        most = with_laws(stated.observations, stated.covariance, float(np.sum((basis.T @ stated.white) ** 2)))
        if most.cost > found.cost + SURE:
            return found
    return likeliest([explained_mean(stated, sensor), found])


def beside_setting(mean: MeanFindings, stated: MeasuredForms, sensor: Sensor) -> MeanFindings:
    """What the mean depth says beside what its laws compete with: poses, targets or meshes are worse than stated.

    Where that is likelier its sizes hold, and laws are asked for again in their units. Nothing is established by a
    model that does not foresee what it was fitted to.

    Args:
        stated: the recordings with errors as stated: sizes that were found beside laws are none without them.
        sensor: the given model.
    """
    # in stated errors, and in those that follow no law: what these do hides a wrong camera
    units = (stated,) if mean.seen is stated else (stated, mean.seen)
    free = min((without_laws(one.observations, one.covariance) for one in units), key=lambda one: one.cost)
    if mean.claims and _may_pose_as_laws(free, mean):
        again = _again(mean, stated, free, sensor)
        # what the form of laws that explain so much may leave is no sign of errors beside them
        mean = again if again.cost < mean.cost - FORM * mean.gain else mean
    beside = *_beside_parts(mean, stated.observations.sensor), *_beside_plainer(mean)
    setting = min((free, *beside), key=lambda one: one.cost)
    laws = with_laws(mean.seen.observations, mean.seen.covariance, mean.gain if mean.claims else 0.0)
    sure = posterior(laws, setting)
    if not mean.foresees:  # not established, and still what is said where no setting is likelier
        mean = mean.unconfirmed
    if sure >= CONFIDENCE:
        return replace(mean, posterior=sure) if mean.claims else mean
    if sure > 1.0 - CONFIDENCE:
        other = free.observations.loose != mean.seen.observations.loose
        return replace(mean.unconfirmed, posterior=sure, rival=free if setting is free and other else None)
    again = _again(mean, stated, setting, sensor)
    if not again.claims or not again.foresees:
        return replace(again.unconfirmed, posterior=sure)
    seen = again.seen.observations, again.seen.covariance
    both = posterior(with_laws(*seen, again.gain), with_laws(*seen, 0.0))
    return replace(again if both >= CONFIDENCE else again.unconfirmed, posterior=both)


def _may_pose_as_laws(setting: Explained, mean: MeanFindings) -> bool:
    """True where a mesh or camera file is likely wrong, or a law has no name: its errors look like laws."""
    loose = setting.observations.loose
    return bool(loose.mesh or loose.camera) or (mean.beyond is not None and mean.beyond.law.replicated)


def _again(mean: MeanFindings, stated: MeasuredForms, setting: Explained, sensor: Sensor) -> MeanFindings:
    """What the recordings say in the units of another setting."""
    before = replace(stated.observations, loose=setting.observations.loose)
    before = before.seen_again(at_likely_poses(mean.seen.blocks, before, setting.covariance))
    blocks = [patch.block for patch in before.patches]
    return explained_mean(MeasuredForms.of(blocks, before, setting.covariance), sensor)


def _beside_parts(mean: MeanFindings, given: Sensor) -> Iterator[Explained]:
    """The likeliest setting with every part of the laws that were found, at the price of that part.

    In the units of these laws: what they leave to no law, a drift, is left to none here either.
    """
    seen, names = mean.seen, sorted({step.effect.name for step in mean.named.steps})
    beyond = mean.beyond.law.score if mean.beyond is not None and mean.beyond.law.replicated else 0.0
    parts = setting_parts(seen.observations, seen.covariance) if len(names) + bool(beyond) > 1 else None
    for kept in (set(some) for size in range(1, len(names) + bool(beyond)) for some in combinations(names, size)):
        rest = seen.observations.under(_with_only(mean.named.sensor, kept, set(names), given))
        price = sum(step.price for step in mean.named.steps if step.effect.name in kept)
        setting = without_laws(rest, seen.covariance, parts)
        yield replace(setting, cost=setting.cost + price)


def _beside_plainer(mean: MeanFindings) -> Iterator[Explained]:
    """The likeliest settings with a law of few numbers in place of fields: those follow it and a bent target."""
    seen, steps = mean.seen, mean.named.steps
    kept = [step for step in steps if not is_field(step.candidate)]
    plain = [c for c in seen.candidates if not is_field(c) and not c.where]
    if len(kept) == len(steps) or not plain:
        return
    parts = [EffectPart(step.candidate, step.weights) for step in kept]
    space, target = partial_residual(refitted(parts, seen.observations, seen.covariance), None)
    found: dict[str, tuple[Candidate, Scored]] = {}
    for one in sorted(zip(plain, scores(plain, space, target), strict=True), key=lambda one: -one[1].score):
        found.setdefault(one[0].name, one)
    for candidate, own in [*found.values()][:LARGEST_SET]:
        fit = refitted([*parts, EffectPart(candidate, own.weights)], seen.observations, seen.covariance)
        setting = without_laws(seen.observations.under(fit.sensor), seen.covariance)
        yield replace(setting, cost=setting.cost + own.gain - own.score + sum(step.price for step in kept))


def _with_only(better: Sensor, kept: Set[str], found: Set[str], given: Sensor) -> Sensor:
    """A better model with some of the effects that were found; the others as they were given, or not at all."""
    for name in found - kept:
        own = given.effect(name)
        rest = replace(better, effects=tuple(effect for effect in better.effects if effect.name != name))
        better = rest if own is None else better.having(own)
    return better
