"""Mean: which laws the mean depth of recordings establishes, beside a setting that is only worse than stated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fusion.discrepancy.decisions import CONFIDENCE, LARGEST_SET, NOISE_ALONE, SURE
from fusion.discrepancy.held_out import HeldOut, held_out_of
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, TileCovariance
from fusion.discrepancy.naming.naming import Named, name_effects, suggested, unconfirmed
from fusion.discrepancy.naming.search.candidates import Candidate, candidates_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.setting import Explained, with_laws
from fusion.discrepancy.unknown.in_place import explains_more, is_asked
from fusion.discrepancy.unknown.unknown import Unknown, unknown_of
from fusion.discrepancy.unknown.unrestricted import Group, UnrestrictedGain, explained, groups_of
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]


UNKNOWN_GAIN = 40.0  # beyond what the columns cost: below, it may be chance
# of all that could be explained: a leftover of less is the form of a named effect, of more: the names are not right
UNKNOWN_SHARE = 0.3


@dataclass(frozen=True)
class MeasuredForms:
    """What was measured, and all forms it is asked for, in the units of one covariance."""

    blocks: tuple[FrameBlock, ...]
    observations: Observations
    covariance: TileCovariance
    groups: tuple[Group, ...]
    candidates: tuple[Candidate, ...]

    @classmethod
    def of(
        cls, blocks: Sequence[FrameBlock], observations: Observations, covariance: TileCovariance
    ) -> "MeasuredForms":
        """All forms in the units of a covariance."""
        groups, candidates = groups_of(observations, covariance), candidates_of(observations, covariance)
        return cls(tuple(blocks), observations, covariance, tuple(groups), tuple(candidates))

    @cached_property
    def white(self) -> Vector:
        """(n,) residual before, in units of the covariance."""
        return self.covariance.whiten(self.observations.residual)


@dataclass(frozen=True)
class MeanFindings:
    """What the mean depth says: names, a law without one, what is left, and frames that took no part."""

    seen: MeasuredForms
    named: Named
    beyond: Unknown | None
    possible: UnrestrictedGain
    left: UnrestrictedGain
    held: HeldOut
    posterior: float = 1.0  # probability that laws are missing, beside a setting that is only worse than stated
    # that setting, where it alone may explain the recordings as well; None elsewhere
    rival: Explained | None = None

    @property
    def claims(self) -> bool:
        """True when a law is established."""
        return bool(self.named.steps) or (self.beyond is not None and self.beyond.law.replicated)

    @property
    def gain(self) -> float:
        """Drop of the chi2 by all laws, less the price of their freedom."""
        whole = float(self.seen.white @ self.seen.white - self.named.white @ self.named.white)
        beyond = self.beyond.law.score if self.beyond is not None and self.beyond.law.replicated else 0.0
        return whole - sum(step.price for step in self.named.steps) + beyond

    @property
    def cost(self) -> float:
        """-2 log of the marginal likelihood of the recordings by laws and errors together."""
        return with_laws(self.seen.observations, self.seen.covariance, self.gain if self.claims else 0.0).cost

    @property
    def foresees(self) -> bool:
        """True where the model with all that is established leaves noise, or little of what there was beyond noise.

        A law that is said of a part of the data must leave noise: else the part is drawn about what was not understood.
        Noise is as large as it is stated; where nothing follows any variable, as large as its grain may be.
        One without a name, beside a camera file that is wrong, may be the rest of its lens: to more than first order,
        or in more numbers than are known of it.
        """
        established = self.beyond is not None and self.beyond.law.replicated
        if established and self.seen.observations.loose.camera:
            return False
        left = self.named.white - (self.beyond.law.footprint if self.beyond is not None and established else 0.0)
        before, after = (float(white @ white / len(white)) for white in (self.seen.white, left))
        bounded = any(step.candidate.where for step in self.named.steps)
        if after <= NOISE_ALONE or (not bounded and after - 1.0 <= UNKNOWN_SHARE * (before - 1.0)):
            return True
        return self.left.gain <= 0 and after <= NOISE_ALONE * _grain_doubt(self.named.sensor)

    @property
    def unconfirmed(self) -> "MeanFindings":
        """The same with nothing established, and all its laws likely."""
        named = suggested(self.named, self.seen.observations, self.seen.white) if self.named.steps else self.named
        return replace(self, named=named, beyond=self.beyond and self.beyond.unconfirmed)

    @property
    def telling(self) -> "MeanFindings":
        """The same with all laws likely that may have too many names: that one of many is there is no finding.

        So are those that are not plainly more than nothing beside the others: without them the model must be less
        likely by `SURE`. Beside laws that are established they stay in the model, whatever they are called.
        """
        sets: dict[str, set[str]] = {}
        sizes: dict[str, float] = {}  # squared, in standard deviations
        for step in self.named.steps:
            name = step.effect.name
            sets.setdefault(name, {name}).update(step.alike)
            sizes[name] = max(sizes.get(name, 0.0), 1 / step.std**2)
        wide = {name for name, names in sets.items() if len(names) > LARGEST_SET or sizes[name] < SURE}
        if not wide:
            return self
        if len(wide) == len(sets):
            return replace(self, named=suggested(self.named, self.seen.observations, self.seen.white))
        steps, others = (
            [s for s in self.named.steps if (s.effect.name in wide) == is_wide] for is_wide in (False, True)
        )
        return replace(self, named=replace(self.named, steps=tuple(steps), likely=(*others, *self.named.likely)))


def _grain_doubt(sensor: Sensor) -> float:
    """How many times the variance of a tile that is stated its grain may make, by what size and window are known to."""
    doubts = [0.0]
    for effect in sensor.effects:
        if effect.frozen == "scene":
            known = [(float(getattr(effect, name)), sensor.std.get((effect.name, name), 0.0)) for name in effect.grain]
            doubts.append(float(np.hypot.reduce([2.0 * float(np.max(std)) / size for size, std in known if size > 0])))
    return 1.0 + float(ndtri(CONFIDENCE)) * max(doubts)


def explained_mean(seen: MeasuredForms, sensor: Sensor) -> MeanFindings:
    """Names and laws of the mean depth that the recordings establish in the units of one covariance."""
    before, covariance, white = seen.observations, seen.covariance, seen.white
    possible = explained(white, list(seen.groups), np.zeros((len(white), 0)))
    named = name_effects(seen.blocks, before, covariance, list(seen.candidates))
    held = held_out_of(seen.blocks, sensor, before)
    if named.steps and held.contradicts(named.sensor, _due(named, white)):
        named = unconfirmed(named, before, white)
    named, beyond, left = _completed(named, seen, possible)
    if beyond is not None and held.contradicts(beyond.added_to(named.sensor), beyond.law.gain, named.sensor):
        beyond = beyond.unconfirmed
    return MeanFindings(seen, named, beyond, possible, left, held)


def likeliest(ways: Sequence[MeanFindings]) -> MeanFindings:
    """Of the same recordings with errors of several sizes the one that laws and errors together explain best."""
    if len(ways) == 1:
        return ways[0]
    return min(ways, key=lambda mean: mean.cost)


def _completed(
    named: Named,
    seen: MeasuredForms,
    possible: UnrestrictedGain,
) -> tuple[Named, Unknown | None, UnrestrictedGain]:
    """The names that hold, the form of what no effect explains, and what is left.

    Args:
        named: effects that were added.
        possible: what could be explained at all.
    """
    before, covariance, white = seen.observations, seen.covariance, seen.white
    groups, candidates = list(seen.groups), seen.candidates
    beyond = None
    left = explained(named.white, groups, np.zeros((len(white), 0)))
    if is_asked(named):  # whether one formula stands behind the names
        formula = unknown_of(white, MeasuredTiles(before, covariance), possible, candidates, groups)
        if explains_more(formula.law, named, white):
            named, beyond, left = unconfirmed(named, before, white), formula, possible
    if named.steps and _is_much(left, named, possible):
        # the names explain too little of what could be explained: they are the nearest, not the right ones
        named, left = unconfirmed(named, before, white), possible
    if beyond is None and _is_much(left, named, possible):
        beyond = unknown_of(named.white, MeasuredTiles(named.observations, covariance), left, candidates, groups)
    return named, beyond, left


def _due(named: Named, white: Vector) -> float:
    """Gain of which frames that took no part must show a share; 0 with a region: its edge is known to a look only."""
    if any(step.candidate.where for step in named.steps):
        return 0.0
    return float(white @ white - named.white @ named.white)


def _is_much(left: UnrestrictedGain, named: Named, possible: UnrestrictedGain) -> bool:
    """True when what is left is no chance, and no mere matter of the form of a named effect."""
    whole = max(possible.gain, _gain(named) + left.gain)
    return left.gain > UNKNOWN_GAIN and left.gain > UNKNOWN_SHARE * whole


def _gain(named: Named) -> float:
    return sum(step.gain for step in named.steps)
