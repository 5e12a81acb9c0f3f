"""What views have in common and what each has for itself: exposure, sharpness; and where one shows another thing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROUNDS = 15  # of an alternation that halves its error each time where views overlap
FITS = 0.3  # in the logarithm: a place that differs by more counts less (guess: what light does to a side that turns)
SIDES = 3  # of an object in one view, that light changes apart from each other: those of a box
WHITE, BRIGHTEST = 255.0, 0.99  # [counts]; share of the surface that is to be no brighter
DARKEST = 8.0  # [counts] below, ratios are noise
# [counts] a view that differs by more from the middle of all shows another thing, or a gloss. 20 cost 0.2 dB of a real
# box whose sides a lamp lights differently while they turn (tools/reproduce/scans/texture_held_out.py)
ALIKE = 40.0
LITTLE = 1e-3  # of trust is left to each view: where all disagree, the best one stands


@dataclass(frozen=True)
class SampledView:
    """What one view shows of sample points.

    Attributes:
        index: (k,) the points, each once.
        weight: (k,) above 0.
        low: (k, 3) coarse colour [counts].
        fine: (k,) size of what is fine [counts].
    """

    index: NDArray[np.int64]
    weight: NDArray[np.float32]
    low: NDArray[np.float32]
    fine: NDArray[np.float32]


@dataclass(frozen=True)
class Levels:
    """How views compare.

    Attributes:
        gain: (views, 3) what a view's colours are multiplied with, at most 2.
        sharp: (views,) how much of the fine a view shows, beside the others at the same places; 0.25 to 1.
        trust: (views, points) 0 to 1; 1 where a view does not see a point.
    """

    gain: NDArray[np.float32]
    sharp: NDArray[np.float32]
    trust: NDArray[np.float32]


def levels_of(looks: list[SampledView], points: int) -> Levels:
    """Compare views of `points` sample points."""
    tone = [np.log(np.maximum(look.low, DARKEST)) for look in looks]
    own, left = _parted(looks, tone, points)
    gain = np.exp(-np.clip(_believed(own, left), -np.log(2), np.log(2)))
    fine, _ = _parted(looks, [np.log1p(look.fine)[:, None] for look in looks], points)
    sharp = np.exp(fine[:, 0] - fine[:, 0].max()) if len(looks) else np.ones(0)
    middle = _medians(looks, [look.low * gain[i] for i, look in enumerate(looks)], points)
    # white that a camera took darker would be made whiter than white: then all is made darker
    seen = middle[middle.any(axis=1)]
    fit = min(1.0, WHITE / float(np.quantile(seen.max(axis=1), BRIGHTEST))) if len(seen) else 1.0
    gain, middle = gain * fit, middle * np.float32(fit)
    trust = np.ones((len(looks), points), np.float32)
    for i, look in enumerate(looks):
        apart = ((look.low * gain[i] - middle[look.index]) ** 2).sum(axis=1)
        trust[i, look.index] = np.maximum(np.exp(-apart / (2 * ALIKE**2)), LITTLE)
    return Levels(gain.astype(np.float32), np.clip(sharp, 0.25, 1).astype(np.float32), trust)


def _believed(own: NDArray[np.float64], left: float) -> NDArray[np.float64]:
    """Exposures (views, 3) as far as they spread by more than light does that differs between the sides of an object.

    Of light that differs by s (standard deviation) between n sides a view's mean takes s^2 / n, which looks like an
    exposure, and s^2 (n - 1) / n is left over: `left` squared.
    """
    spread = float(np.mean(own**2)) if len(own) else 0.0
    return own * max(0.0, 1 - left**2 / (SIDES - 1) / spread) if spread > 0 else own


def _parted(looks: list[SampledView], values: list[NDArray], points: int) -> tuple[NDArray[np.float64], float]:
    """Values as a sum of one of each view (views, c) and one of each point; what is left over, rms.

    By least squares whose weights fall where a view does not fit: a hand in it must not change its exposure.
    """
    channels = values[0].shape[1] if values else 1
    own, shared = np.zeros((len(looks), channels)), np.zeros((points, channels))
    weights = [look.weight.astype(float) for look in looks]
    away = [np.zeros(0)] * len(looks)
    for _ in range(ROUNDS):
        total = np.full((points, 1), 1e-12)
        shared[:] = 0
        for i, look in enumerate(looks):
            total[look.index, 0] += weights[i]
            shared[look.index] += weights[i][:, None] * (values[i] - own[i])
        shared /= total
        for i, look in enumerate(looks):
            if len(look.index):
                own[i] = np.average(values[i] - shared[look.index], axis=0, weights=weights[i])
                away[i] = np.abs(values[i] - own[i] - shared[look.index]).max(axis=1)
                weights[i] = look.weight * FITS / np.maximum(away[i], FITS)  # Huber: one best answer, none of several
        own -= own.mean(axis=0) if len(own) else 0
    if not sum(map(len, away)):
        return own, 0.0
    return own, float(np.sqrt(np.average(np.concatenate(away) ** 2, weights=np.concatenate(weights))))


def _medians(looks: list[SampledView], values: list[NDArray], points: int) -> NDArray[np.float32]:
    """(points, 3) weighted medians, 0 where no view sees a point."""
    middle = np.zeros((points, 3), np.float32)
    if not looks:
        return middle
    index = np.concatenate([look.index for look in looks])
    weight = np.concatenate([look.weight for look in looks]).astype(float)
    for channel in range(3):
        value = np.concatenate([v[:, channel] for v in values])
        order = np.lexsort((value, index))
        who, running = index[order], np.cumsum(weight[order])
        first = np.flatnonzero(np.r_[True, who[1:] != who[:-1]])
        last = np.r_[first[1:], len(who)] - 1
        before = np.where(first > 0, running[first - 1], 0.0)
        half = (before + running[last]) / 2
        middle[who[first], channel] = value[order][np.clip(np.searchsorted(running, half), first, last)]
    return middle
