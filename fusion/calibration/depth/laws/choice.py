"""Which law is used: what walls left out say of the candidates, by more than their own uncertainty."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.selection import FittedLaw, JudgedLaw

NEGLIGIBLE = 4.0  # of chi2: what one number that means nothing is expected to gain is 1; two standard deviations, 4
PROMISING = 12  # laws that are tried with one more radial term: the first ten differ by less than that term does


def choose(judged: Sequence[JudgedLaw], allowed: Sequence[bool] | None = None) -> int:
    """The candidate to use: index among `judged`, of which the first is no law at all; one that is `allowed`.

    Every wall is left out once, and laws are compared wall by wall; a difference counts where it is more than its
    standard error over the walls. Pixels of one wall err together, so their number does not.

    A law is taken only if it helps in plain millimetres: the weighted error, chi2, is mostly the shape of the walls,
    and laws of many terms buy that with their distances. Of these the one of the fewest millimetres counts, or a
    simpler one that falls behind in neither measure; in chi2 by no more than numbers that mean nothing gain, either,
    for few or restless walls have wide standard errors.
    A law of which one number is smaller than its standard deviation is not established, and not taken. Of a single
    wall nothing can be held out: it gets no law.
    """
    if len(judged[0].rms) < 2:
        return 0
    plain = [j.rms**2 for j in judged]
    some = [i for i in range(1, len(judged)) if allowed is None or allowed[i]]
    found = [i for i in some if established(judged[i].law) and less(plain[i], plain[0])]
    if not found:
        return 0
    nearest = min(found, key=lambda i: float(plain[i].sum()))
    chi2 = [j.chi2 for j in judged]
    near = [i for i in found if not less(plain[nearest], plain[i])]
    lost = [float(np.sum(one - chi2[nearest])) for one in chi2]
    alike = [i for i in near if lost[i] <= NEGLIGIBLE and not less(chi2[nearest], chi2[i])]
    return min(alike, key=lambda i: (complexity(judged[i]), float(chi2[i].sum())))


def less(one: NDArray[np.floating], other: NDArray[np.floating]) -> bool:
    """Whether squared errors (w,) on walls left out are less than others by more than their difference's deviation."""
    difference = other - one
    return bool(difference.mean() > difference.std(ddof=1) / np.sqrt(len(difference)))


def promising(judged: Sequence[JudgedLaw]) -> list[JudgedLaw]:
    """The established laws that err least on walls left out, in either measure."""
    some = [j for j in judged if established(j.law)]
    by_weight = sorted(some, key=lambda j: float(j.chi2.sum()))[: PROMISING // 2]
    rest = sorted((j for j in some if j not in by_weight), key=lambda j: j.error)
    return by_weight + rest[: PROMISING - len(by_weight)]


def refused(judged: Sequence[JudgedLaw], chosen: int) -> JudgedLaw | None:
    """The law of least chi2, where it was left for what it costs in millimetres; None where the chosen one is it."""
    if len(judged[0].rms) < 2:
        return None
    best = min((j for j in judged if established(j.law)), key=lambda j: float(j.chi2.sum()))
    mine = judged[chosen]
    return best if best is not mine and less(best.chi2, mine.chi2) and best.error > mine.error else None


def complexity(judged: JudgedLaw) -> int:
    """Numbers of the law; a surface is richer than any."""
    return judged.candidate.numbers + 100 * bool(judged.candidate.surface)


def established(law: FittedLaw) -> bool:
    """True when every number exceeds its deviation: a wave by its amplitude, curves, delays, tilts, radial terms whole.

    The offset beside waves is the middle of their curve: it may be 0. The share that a board mirrors is above 0.
    """
    values: dict[str, tuple[float, float]] = {}
    wavy = any(key.startswith("sin ") for key in law.keys)
    for key, number, variance in zip(law.keys, law.numbers, np.diag(law.covariance), strict=True):
        head = key.split()[0]
        if wavy and head == "offset":
            continue
        name = "wave " + key[4:] if head in ("sin", "cos") else head if head in ("curve", "delay", "tilt") else key
        name = "radius" if name.startswith("radius") else name
        size, deviation = values.get(name, (0.0, 0.0))
        own = float(number) if key == "gloss" else abs(float(number))
        values[name] = max(size, own), max(deviation, float(np.sqrt(variance)))
    return all(size > deviation for size, deviation in values.values())
