"""Judging what was tried of the noise: by chance, by its size, in recordings left out, in frames left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fusion.discrepancy.channels.noise_parameters import (
    NoiseParameter,
    known_parameters,
    new_parameters,
    own_parameters,
)
from fusion.discrepancy.channels.scatter import Scatter, scatter_of
from fusion.discrepancy.channels.turning import COMMON, TunedParameters, Whitener, changes, turn
from fusion.discrepancy.decisions import FALSE_ALARM, REPLICATED
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

BEYOND = 0.005  # chance that a stated value, within its own standard deviation, is as far off as it seems
LEAST_CHANGE = 3 * COMMON  # of a variance, in the tiles that change most: below, it is a matter of the noise model
EXPLAINED = 0.5  # of what is too much, by one effect: two of a size may be there
FAR = 6.0  # standard deviations, of a tile that would decide alone
SIMPLER = 6.0  # of the chi2: a value that is wrong needs no new physics


@dataclass(frozen=True)
class Tried:
    """One explanation: which parameters became free, and where they stand then."""

    name: str
    free: tuple[NoiseParameter, ...]
    turned: TunedParameters
    gain: float
    corrected: bool

    @property
    def score(self) -> float:
        return self.gain + (SIMPLER if self.corrected else 0.0) - 2.0 * len(self.free)


def probability(best: Tried, names: int) -> float:
    """Of a gain like this by chance; a value that is known wrongly has only its own chance."""
    gain, k = max(best.gain, 0.0), len(best.free)
    chance = float(chdtrc(k, gain))
    return chance if best.corrected else min(1.0, names * chance)


def improbable(best: Tried, names: int) -> bool:
    return probability(best, names) <= (BEYOND if best.corrected else FALSE_ALARM)


def large(best: Tried, before: TunedParameters) -> bool:
    excess = np.abs(best.turned.excess() - before.excess())
    difference = np.maximum(excess, np.abs(best.turned.renewal() - before.renewal()))
    return bool(np.quantile(difference, 0.9) > LEAST_CHANGE)


def explains(best: Tried, before: TunedParameters) -> bool:
    """True when it brings a good part of what is too much: less, and the name is not the right one."""
    excess = before.chi2 - 2 * len(before.excess())
    return before.chi2 - best.turned.chi2 > EXPLAINED * excess


def in_succession(one: Tried, before: TunedParameters, scatter: Scatter, whitener: Whitener) -> bool:
    """False for a filter in time whose frames do not follow each other as it says.

    Less noise alone is no filter in time: one that mixes neighbours makes it too, and leaves the frames independent.
    """
    if not any(np.any(param.renewal) for param in one.free):
        return True
    told, none = one.turned.renewal() - before.renewal(), np.zeros(len(scatter))
    expected = whitener.white(scatter, none, none + told)
    found = whitener.white(scatter, none, scatter.renewal - before.renewal())
    return bool(expected @ found >= REPLICATED * (expected @ expected))


def nearer(better: Sensor, scatter: Scatter) -> bool:
    """True when repeated frames scatter more as the better model says, predicted anew.

    What was tried is straight in every number; whatever that made of it, no claim denies what the frames show.
    """
    return _off(scatter_of([patch.under(better) for patch in scatter.patches])) < _off(scatter)


def _off(scatter: Scatter) -> float:
    """Mean size of the logarithms by which frames scatter otherwise than is said."""
    told = np.isfinite(scatter.renewal_sigma)
    renewal = np.where(told, np.abs(scatter.renewal), 0.0)
    return float(np.mean(np.abs(scatter.excess) + renewal))


def replicated(best: Tried, before: TunedParameters, scatter: Scatter, whitener: Whitener) -> bool:
    """True when recordings that took no part in the fit show it too, and not one alone."""
    places = np.unique(scatter.place)
    if len(places) < 3:
        return True
    gains = []
    for g in places:
        rest, part = scatter.place != g, scatter.place == g
        few = [param.only(rest) for param in best.turned.params]
        values = turn(scatter.only(rest), whitener, few, best.turned.values).values
        gain = 0.0
        for sign, params, at in ((1, before.params, before.values), (-1, best.turned.params, values)):
            gain += sign * _bounded_chi2(scatter.only(part), whitener, [param.only(part) for param in params], at)
        gains.append(gain)
    whole = [_bounded_chi2(scatter, whitener, turned.params, turned.values) for turned in (before, best.turned)]
    enough = REPLICATED * (whole[0] - whole[1])
    return float(np.sum(gains)) > enough and max(gains) < 0.8 * float(np.maximum(gains, 0).sum())


def _bounded_chi2(
    scatter: Scatter, whitener: Whitener, params: Sequence[NoiseParameter], values: Sequence[float] | Vector
) -> float:
    """What parameters at some values leave, where no tile counts for more than `FAR`."""
    white = np.clip(_white(scatter, whitener, params, values), -FAR, FAR)
    return float(white @ white)


def confirmed(
    best: Tried, before: TunedParameters, sensor: Sensor, held: Sequence[FrameBlock], whitener: Whitener
) -> bool:
    """True unless frames that took no part in the fit deny it."""
    some = [block for block in held if len(block.frames) >= 2]
    if not some:
        return True
    scatter = scatter_of([p for p in observe(sensor, some).patches if len(p.tiles)])
    wanted = frozenset(param.key for param in best.turned.params)
    own = (param for way in own_parameters(scatter) for param in way)
    again = {
        k.form: k
        for k in [*own, *known_parameters(sensor, scatter, frozenset()), *new_parameters(sensor, scatter, wanted)]
    }
    whites = []
    for turned in (before, best.turned):
        pairs = [(again[k.form], v) for k, v in zip(turned.params, turned.values, strict=True) if k.form in again]
        whites.append(_white(scatter, whitener, [param for param, _ in pairs], [value for _, value in pairs]))
    expected = whites[0] - whites[1]
    return bool(expected @ whites[0] > REPLICATED * (expected @ expected))


def _white(
    scatter: Scatter, whitener: Whitener, params: Sequence[NoiseParameter], values: Sequence[float] | Vector
) -> Vector:
    """(2 n,) what parameters at some values leave, whitened."""
    excess, renewal = changes(params, values)
    return whitener.white(scatter, scatter.excess - excess, scatter.renewal - renewal)
