"""What views have in common and what each has for itself: exposure, light, sharpness; where one shows another thing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.texture.lighting.exposure import SampledView, exposed, seen_of
from fusion.texture.lighting.light import Facings, Lighting
from fusion.texture.lighting.parted import parted

WHITE, BRIGHTEST = 255.0, 0.99  # [counts]; share of the surface that is to be no brighter
# [counts] a view that differs by more from the middle of all shows another thing, or a gloss. 20 cost 0.2 dB of a real
# box whose sides a lamp lights differently while they turn (tools/reproduce/scans/texture_held_out.py)
ALIKE = 40.0
LITTLE = 1e-3  # of trust is left to each view: where all disagree, the best one stands


@dataclass(frozen=True)
class Levels:
    """How views compare."""

    # (views, 3) what a view's colours are multiplied with to be exposed as all are, at most 2
    gain: NDArray[np.float32]
    source: list[int]  # (views,) which camera took each
    lights: list[Lighting]  # before each camera
    # (views,) how much of the fine a view shows, beside the others at the same places; 0.25 to 1
    sharp: NDArray[np.float32]
    trust: NDArray[np.float32]  # (views, points) 0 to 1; 1 where a view does not see a point

    def even(self, view: int, facing: Facings) -> NDArray[np.float32]:
        """(k, 3) what a view's colours are multiplied with at parts of the surface."""
        return np.asarray(self.gain[view] / self.lights[self.source[view]].on(facing))


def levels_of(looks: list[SampledView], points: int) -> Levels:
    """Compare views, one at least of which shows some of `points` sample points."""
    found = exposed(looks, points)
    gain = np.exp(-np.clip(found.views, -np.log(2), np.log(2))).astype(np.float32)
    lights, source = found.lights, [look.source for look in looks]
    evened = [look.low * gain[i] / lights[look.source].on(look.facing) for i, look in enumerate(looks)]
    middle = _medians(looks, evened, points)
    # white that a camera took darker would be made whiter than white: then all is made darker
    seen = middle[middle.any(axis=1)]
    fit = min(1.0, WHITE / float(np.quantile(seen.max(axis=1), BRIGHTEST)))
    trust = np.ones((len(looks), points), np.float32)
    for i, look in enumerate(looks):
        apart = ((evened[i] - middle[look.index]) ** 2).sum(axis=1) * fit**2
        trust[i, look.index] = np.maximum(np.exp(-apart / (2 * ALIKE**2)), LITTLE)
    return Levels(gain, source, [light.brighter(1 / fit) for light in lights], _sharp(looks, points), trust)


def _sharp(looks: list[SampledView], points: int) -> NDArray[np.float32]:
    """(views,) how much of the fine each shows."""
    fine = parted(seen_of(looks, [np.log1p(look.fine)[:, None] for look in looks]), len(looks), points).views[:, 0]
    return np.clip(np.exp(fine - fine.max()), 0.25, 1).astype(np.float32)


def _medians(looks: list[SampledView], values: list[NDArray], points: int) -> NDArray[np.float32]:
    """(points, 3) weighted medians, 0 where no view sees a point."""
    middle = np.zeros((points, 3), np.float32)
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
