"""Grain: what the pixels of one tile have each for themselves and no frame changes.

The mean of a tile shows next to nothing of it: speckle, new with each placement, and the pattern of a unit, the same in
all. Frames that take no part in any fit have noise of their own and the same grain: what both have in common is grain,
whatever the noise is.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.noise_parameters import USUAL
from fusion.discrepancy.channels.scatter import frozen_rounding
from fusion.discrepancy.decisions import FALSE_ALARM
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.observe.tiles import Tiling
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

FEWEST = 3  # placements: a spread among them is asked for
APART_PX = (0, 1, 2, 4, 8)  # pixels of a square so far apart are compared: what they share tells grain from a shape
SHAPED = 0.3  # of the grain, by which that may be other than its window makes it
WITHIN = 2.0  # standard deviations of a stated size, within which it is as stated
TRIMMED = 0.1  # of the tiles, at each end
LEAST_SHARE = 0.1  # of the variance of a frame: what is less lies within what is known of noise and rounding

TEXT = {
    "scene": "every pixel keeps an error of its own while the scene stands still, and another in the next recording",
    "unit": "every pixel has an error of its own, the same in all recordings",
}


@dataclass(frozen=True)
class Grain:
    """Upright images (h, w) of one placement, from frames that were fitted and from others; 0 beside the tiles."""

    patch: Patch  # whose
    # fitted, others: measured less predicted without each tile's plane, in native units
    fitted: Image
    others: Image
    whole: float  # mean square of what both have in common with their planes, in native units squared

    @property
    def noise(self) -> float:
        """Variance of a pixel in one frame, in native units squared: noise, and what rounding may keep of it."""
        squares = self.patch.tiles.mean((self.patch.block.std * self.patch.native) ** 2)
        return float(np.nanmedian(squares)) + frozen_rounding(self.patch)

    @property
    def inside(self) -> NDArray[np.bool_]:
        return self.patch.tiles.label >= 0

    @property
    def of_length(self) -> Image:
        """(h, w) native units of an error of length that is the same in all placements."""
        return np.where(self.inside & (not self.patch.view.time_of_flight), self.patch.native, 1.0)

    def common(self, theirs: Image, inside: NDArray[np.bool_]) -> Vector:
        """Covariance with another image, of pixels of one tile that are `APART_PX` apart."""
        label, found = self.patch.tiles.label, []
        for steps in APART_PX:
            for axis in (0, 1):
                same = self.inside & (np.roll(label, steps, axis) == label) & np.roll(inside, steps, axis)
                found.append(_usual(self.patch.tiles, self.fitted * np.roll(theirs, steps, axis), same))
        return np.reshape(found, (len(APART_PX), 2)).mean(axis=1)


def with_grain(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with grain that it lacks, and each finding."""
    sensor = observations.sensor
    seen = [_grain(patch) for patch in _told_of(observations)]
    if len(seen) < FEWEST:
        return sensor, ()
    own, shared = _covariances(seen)
    steps: list[ChannelStep] = []
    for kind in EFFECTS:
        if kind.grain and (not kind.principles or sensor.principle in kind.principles):
            step = _step(kind, sensor, own if kind.frozen == "scene" else shared, seen)
            steps += [] if step is None else [step]
            sensor = sensor if step is None else step.added_to(sensor)
    return sensor, tuple(steps)


def _covariances(seen: Sequence[Grain]) -> tuple[Matrix, Matrix]:
    """(m, k) of pixels `APART_PX` apart, in native units squared: what a placement has for itself, and with all others.

    Less what rounding may leave.
    """
    inside = np.array([one.inside for one in seen])
    lengths = np.array([one.others / one.of_length for one in seen])
    count, total = inside.sum(axis=0), lengths.sum(axis=0)
    own, shared = np.zeros((2, len(seen), len(APART_PX)))
    for k, one in enumerate(seen):
        rest = count - inside[k]
        shared[k] = one.common((total - lengths[k]) / np.maximum(rest, 1) * one.of_length, rest > 0)
        own[k] = one.common(one.others, one.inside) - shared[k]
        own[k, 0] -= frozen_rounding(one.patch)
    return own, shared


def _told_of(observations: Observations) -> list[Patch]:
    """Patches of placements seen once, with frames held out, and no simulation in the place of the prediction."""
    places = [patch.block.place for patch in observations.patches]
    return [
        patch
        for patch in observations.patches
        if patch.block.held is not None and patch.block.given is None and places.count(patch.block.place) == 1
        and len(patch.tiles) >= FEWEST and np.isfinite(patch.block.std).any()
    ]  # fmt: skip


def _grain(patch: Patch) -> Grain:
    assert patch.block.held is not None
    off = [np.nan_to_num((block.mean - patch.predicted) * patch.native) for block in (patch.block, patch.block.held)]
    whole = float(np.mean((off[0] * off[1])[patch.tiles.label >= 0]))
    fitted, others = (_upright(patch, image) for image in off)
    return Grain(patch, fitted, others, whole)


def _upright(patch: Patch, off: Image) -> Image:
    """An image (h, w) without the plane of each tile; 0 beside them."""
    used = patch.tiles.label >= 0
    number = patch.tiles.label[used]

    def mean(values: NDArray[np.floating]) -> Vector:
        return np.bincount(number, values, minlength=len(patch.tiles)) / patch.tiles.pixels

    v, u = (axis.astype(float) for axis in np.nonzero(used))
    x, y, e = (values - mean(values)[number] for values in (u, v, off[used]))
    xx, xy, yy, xe, ye = (mean(product) for product in (x * x, x * y, y * y, x * e, y * e))
    size = np.maximum(xx * yy - xy * xy, 1e-9)
    a, b = (xe * yy - ye * xy) / size, (ye * xx - xe * xy) / size
    out = np.zeros(off.shape)
    out[used] = e - a[number] * x - b[number] * y
    return out


def _usual(tiles: Tiling, product: Image, inside: NDArray[np.bool_]) -> float:
    """Mean over the tiles of a product of images, without those at both ends: edges and bands are in a few of them."""
    share = tiles.mean(inside.astype(float))
    some = share > 0.3
    if not some.any():
        return 0.0
    means = np.sort(tiles.mean(np.where(inside, product, 0.0))[some] / share[some])
    ends = int(TRIMMED * len(means))
    return float(means[ends : len(means) - ends].mean())


def _power(effect: Effect, patch: Patch) -> float:
    """Mean square of an effect's grain in native units, as it is seen without the planes of the tiles."""
    with np.errstate(all="ignore"):
        whole = float(np.median(patch.tiles.mean((effect.noise(patch.depth, patch.view) * patch.native) ** 2)))
    return whole * float(_as_seen(effect.window(patch.view), _side(patch))[0])


def _side(patch: Patch) -> int:
    """Of the squares [px], as many pixels as are used of them."""
    return round(float(np.sqrt(np.median(patch.tiles.pixels))))


def _as_seen(window: float, side: int) -> Vector:
    """Covariances of pixels `APART_PX` apart that share a window, in squares without their mean and slopes; variance
    of a pixel 1."""
    steps = np.arange(side)
    alike = np.maximum(1.0 - np.abs(steps[:, None] - steps) / max(window, 1.0), 0.0)
    flat, slope = (axis / np.linalg.norm(axis) for axis in (np.ones(side), steps - steps.mean()))

    def apart(products: Matrix) -> Vector:
        both, most = 0.5 * (products + products.T), side - 1
        return np.array([np.diagonal(both, min(k, most)).mean() for k in APART_PX])

    out = apart(alike)
    for x, y in ((flat, flat), (slope, flat), (flat, slope)):  # of the image, along and across the step
        along, across = x @ alike @ x, y @ alike @ y / side
        out = out + across * (along * apart(np.outer(x, x)) - 2 * apart(np.outer(x, alike @ x)))
    return out


def _step(kind: type[Effect], sensor: Sensor, found: Matrix, seen: Sequence[Grain]) -> ChannelStep | None:
    """An effect with as much grain as is found, where that is more than is stated; None where it is not."""
    size, *window = kind.grain
    known, noise = sensor.effect(kind.name), np.array([one.noise for one in seen])
    if not np.all(noise > 0):
        return None
    unit: dict[str, Any] = {size: 1.0}
    one, found = kind(**unit) if known is None else replace(known, **unit), found / noise[:, None]

    def powers() -> Vector:
        return np.array([_power(one, grain.patch) for grain in seen]) / noise

    weights, patch = powers() / powers().sum(), seen[0].patch
    apart = weights @ found
    if apart[0] < LEAST_SHARE:
        return None
    windows = np.linspace(1.0, APART_PX[-1], 57) if window and known is None else np.array([one.window(patch.view)])
    due = np.array([_as_seen(window_px, _side(patch)) for window_px in windows])
    due /= due[:, :1]
    best = int(np.argmin(np.linalg.norm(apart / apart[0] - due, axis=1)))
    if np.max(np.abs(apart / apart[0] - due[best])) > SHAPED:
        return None
    if window and known is None:
        wide: dict[str, Any] = {window[0]: float(windows[best])}
        one = replace(one, **wide)
    power, sizes = powers(), found[:, 0]
    square = float(power @ sizes / (power @ power))
    spread = float(np.linalg.norm(sizes - square * power) / np.sqrt((len(seen) - 1) * (power @ power)))
    chance = float(stdtr(len(seen) - 1, (_stated(known, size, sensor) - square) / max(spread, 1e-300)))
    if not chance <= FALSE_ALARM:
        return None
    value = float(np.sqrt(square))
    fitted: dict[str, Any] = {size: min(value, parameters(kind)[size].high)}
    std, gain = {size: spread / (2 * value)}, float(sizes.sum())
    share = float(np.clip(gain / (np.array([grain.whole for grain in seen]) / noise).sum(), 0.0, 1.0))
    corrected = known is not None and bool(np.any(getattr(known, size)))
    return ChannelStep("bias", replace(one, **fitted), std, corrected, gain, share, chance, text=TEXT[kind.frozen])


def _stated(known: Effect | None, size: str, sensor: Sensor) -> float:
    """Square of the largest size that goes with what is stated."""
    if known is None:
        return 0.0
    value = float(np.mean(getattr(known, size)))
    return (value + WITHIN * float(np.max(sensor.std.get((known.name, size), USUAL * value)))) ** 2


def as_given(better: Sensor, given: Sensor, named: Set[str]) -> Sensor:
    """A better model with no more grain than a given one, and all else that it has of effects that are `named`."""
    for effect in better.effects:
        if effect.grain and effect != (own := given.effect(effect.name)):
            size = effect.grain[0]
            if own is None and effect.name not in named:
                better = replace(better, effects=tuple(one for one in better.effects if one is not effect))
            else:
                plain: dict[str, Any] = {size: 0.0 if own is None else getattr(own, size)}
                better = better.having(replace(effect, **plain))
    return better
