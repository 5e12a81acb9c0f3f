"""Judging laws by what each says about a wall that it has not seen."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.candidates import CandidateLaw
from fusion.calibration.depth.laws.information import Information, WallEvidence
from fusion.calibration.depth.laws.terms import sine
from fusion.calibration.depth.laws.waves import search_waves

PATIENCE = 2
Array = NDArray[np.floating]


@dataclass(frozen=True)
class Problem:
    """All walls as linear problems, with the names of the terms in the order of their columns.

    `waves` remembers which were found: by fold, other terms and allowed periods, for 1, 2, ... waves.
    """

    keys: tuple[str, ...]
    evidence: list[WallEvidence]
    information: list[Information]
    waves: dict[tuple[int, tuple[str, ...], tuple[float, ...]], list[list[int]]] = field(default_factory=dict)

    @cached_property
    def total(self) -> Information:
        """The sums over all walls."""
        return sum(self.information[1:], self.information[0])

    @cached_property
    def others(self) -> list[Information | None]:
        """For each wall the sums over all the others, None where there are none; made once for all candidates."""
        before: list[Information | None] = [None]
        after: list[Information | None] = [None]
        for first, last in zip(self.information[:-1], self.information[:0:-1], strict=True):
            before.append(first if before[-1] is None else before[-1] + first)
            after.append(last if after[-1] is None else after[-1] + last)
        pairs = zip(before, reversed(after), strict=True)
        return [low if high is None else high if low is None else low + high for low, high in pairs]

    def columns(self, alternative: tuple[str, ...]) -> list[int]:
        """Columns of the named terms."""
        return [self.keys.index(key) for key in alternative]

    def sines(self, periods: tuple[float, ...]) -> NDArray[np.intp]:
        """Columns of the sines of these periods [m], of all where there are none."""
        allowed = {sine(period) for period in periods}
        return np.array([i for i, k in enumerate(self.keys) if k in allowed or (not allowed and k.startswith("sin "))])


@dataclass(frozen=True)
class FittedLaw:
    """A candidate with its numbers."""

    keys: tuple[str, ...]  # terms (n,)
    numbers: Array  # (n,)
    covariance: Array  # (n, n)
    chi2: float  # weighted square of what is left over
    held: bool = False  # True when the periods of its waves are known


@dataclass(frozen=True)
class JudgedLaw:
    """A candidate's errors on walls that were left out of its fit."""

    candidate: CandidateLaw  # which
    law: FittedLaw  # fitted to all walls
    chi2: Array  # (w,) weighted square of what the fit to the others leaves over on each wall
    offset: Array  # (w,) the wall's error on the optical axis [m]; NaN where its distance is not known
    rms: Array  # (w,) of the tiles with that error, the tilt taken out [m]
    residual: tuple[Array, ...] = ()  # per wall (t,) the same, tile by tile [m]

    @property
    def error(self) -> float:
        """Root mean square over the walls [m]."""
        return float(np.sqrt(np.mean(self.rms**2)))

    @property
    def axis_error(self) -> float:
        """Root mean square on the axis of the walls whose distance is known [m]; NaN where none is."""
        known = self.offset[np.isfinite(self.offset)]
        return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def fit(problem: Problem, information: Information, candidate: CandidateLaw, fold: int = -1) -> FittedLaw:
    """The numbers of a candidate on the walls of `information`; `fold` names them, so that waves are searched once."""
    keys = candidate.keys
    if candidate.waves:
        waves = problem.sines(candidate.periods)
        known = problem.waves.setdefault((fold, keys, candidate.periods), [])
        if len(known) < candidate.waves:
            fixed = problem.columns(keys)
            for number in range(len(known) + 1, candidate.waves + 1):
                begin = known[-1] if known else []
                known.append(search_waves(information, fixed, waves, number, begin))
        sines = known[candidate.waves - 1]
        keys = (*keys, *(problem.keys[column] for sine in sines for column in (sine, sine + 1)))
    chosen = problem.columns(keys)
    numbers = information.fit(chosen)
    covariance, chi2 = information.covariance(chosen), information.chi2(chosen, numbers)
    return FittedLaw(keys, numbers, covariance, chi2, bool(candidate.periods))


def judge(problem: Problem, candidate: CandidateLaw) -> JudgedLaw:
    """Leave every wall out once."""
    total = problem.total
    chi2, offset, rms, left = [], [], [], []
    for which, (evidence, own) in enumerate(zip(problem.evidence, problem.information, strict=True)):
        others = problem.others[which]
        # of a single wall nothing can be held out
        law = fit(problem, total, candidate) if others is None else fit(problem, others, candidate, which)
        chosen = problem.columns(law.keys)
        chi2.append(own.chi2(chosen, law.numbers))
        rest = upright(evidence, evidence.rest - evidence.terms[:, chosen] @ law.numbers)
        offset.append(on_axis(evidence, rest))
        rms.append(float(np.sqrt(np.average(rest**2, weights=evidence.tiles.count))))
        left.append(rest)
    return JudgedLaw(
        candidate, fit(problem, total, candidate), np.array(chi2), np.array(offset), np.array(rms), tuple(left)
    )


def judge_all(problem: Problem, candidates: list[CandidateLaw]) -> list[JudgedLaw]:
    """Judge the candidates; of laws that differ in waves, no more once two more waves have not helped."""
    judged: list[JudgedLaw] = []
    best: dict[tuple[tuple[str, ...], tuple[float, ...]], tuple[float, int]] = {}
    for candidate in candidates:
        family = candidate.keys, candidate.periods
        least, waves = best.get(family, (np.inf, candidate.waves))
        if candidate.waves > waves + PATIENCE:
            continue
        judged.append(judge(problem, candidate))
        chi2 = float(judged[-1].chi2.sum())
        if chi2 < least:
            best[family] = chi2, candidate.waves
    return judged


def upright(evidence: WallEvidence, rest: Array) -> Array:
    """(t,) [m] what is left of `rest` without tilt and distance, each taken out only where it is not known."""
    free = ~np.isfinite([evidence.wall.tilt_std] * 2 + [evidence.distance_std])
    return rest - evidence.nuisances[:, free] @ _nuisances(evidence, rest)[free]


def level(evidence: WallEvidence, rest: Array) -> Array:
    """(t,) [m] what is left of `rest` without tilt and distance."""
    return rest - evidence.nuisances @ _nuisances(evidence, rest)


def on_axis(evidence: WallEvidence, rest: Array) -> float:
    """Error on the optical axis [m]; NaN where the distance is not known."""
    return float(_nuisances(evidence, rest)[2]) if np.isfinite(evidence.distance_std) else float("nan")


def _nuisances(evidence: WallEvidence, rest: Array) -> Array:
    """Tilts and distance (3,) that explain `rest` best."""
    w = 1 / np.sqrt(evidence.variance)
    return np.linalg.lstsq(evidence.nuisances * w[:, None], rest * w, rcond=None)[0]
