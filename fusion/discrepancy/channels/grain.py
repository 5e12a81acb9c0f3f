"""Grain: what the pixels of one tile have each for themselves and no frame changes.

The mean of a tile shows next to nothing of it: speckle, new with each placement, and the pattern of a unit, the same in
all. Frames that take no part in any fit have noise of their own and the same grain: what both have in common is grain,
whatever the noise is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student
from scipy.stats import trim_mean

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.noise_parameters import USUAL
from fusion.discrepancy.channels.scatter import frozen_rounding
from fusion.discrepancy.decisions import FALSE_ALARM
from fusion.discrepancy.inference.own_pattern import unknown_patterns
from fusion.discrepancy.observe.observations import Observations, Patch
from fusion.discrepancy.observe.tiles import Tiling
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image

Vector = NDArray[np.float64]

FEWEST = 3  # placements: a spread among them is asked for
APART_PX = (8, 12)  # pixels so far apart share no grain: what they share is a shape, and told elsewhere
SHAPED = 0.3  # of the grain: with more in common so far apart it is one
UNITS = 8  # drawn of patterns that the model holds: their mean power is good to a third
WITHIN = 2.0  # standard deviations of a stated size, within which it is as stated
TRIMMED = 0.1  # of the tiles, at each end
LEAST_SHARE = 0.1  # of the variance of a frame: what is less lies within what is known of noise and rounding

TEXT = {
    True: "every pixel keeps an error of its own while the scene stands still, and another one in the next recording",
    False: "every pixel has an error of its own, the same in all recordings",
}


@dataclass(frozen=True)
class Grain:
    """Upright images (h, w) of one placement, from frames that were fitted and from others; 0 beside the tiles.

    Attributes:
        patch: whose.
        fitted, others: measured less predicted without each tile's plane, in native units.
        whole: mean square of what both have in common with their planes, in native units squared.
    """

    patch: Patch
    fitted: Image
    others: Image
    whole: float

    @property
    def noise(self) -> float:
        """Variance of a pixel in one frame, in native units squared."""
        return float(np.median(self.patch.tiles.mean((self.patch.block.std * self.patch.native) ** 2)))

    def common(self, other: "Grain | None" = None) -> float:
        """Covariance of the grain of two placements, in native units squared of the first, where an error of length
        is the same in both; of one placement: of its two halves of frames."""
        two, label = other or self, self.patch.tiles.label
        inside = (label >= 0) & (two.patch.tiles.label >= 0)
        same = 1.0 if self.patch.view.time_of_flight else self.patch.native / two.patch.native
        return _usual(self.patch.tiles, self.fitted * two.others * same, inside)

    def along(self, apart: Sequence[int]) -> float:
        """Covariance of pixels of one tile that are so many pixels apart."""
        label, found = self.patch.tiles.label, []
        for steps in apart:
            for axis in (0, 1):
                moved = np.roll(self.others, steps, axis)
                inside = (label >= 0) & (np.roll(label, steps, axis) == label)
                found.append(_usual(self.patch.tiles, self.fitted * moved, inside))
        return float(np.mean(found))


def with_grain(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with grain that it lacks, and each finding."""
    sensor = observations.sensor
    seen = [_grain(patch) for patch in _told_of(observations)]
    if len(seen) < FEWEST:
        return sensor, ()
    shared = [_shared(one, seen) for one in seen]
    own = [a.common() - frozen_rounding(a.patch) - others for a, others in zip(seen, shared, strict=True)]
    steps: list[ChannelStep] = []
    for kind in EFFECTS:
        if kind.grain and (not kind.principles or sensor.principle in kind.principles):
            found = own if kind.anew else [a - _patterns(one.patch) for a, one in zip(shared, seen, strict=True)]
            step = _step(kind, sensor, np.array(found), seen)
            steps += [] if step is None else [step]
            sensor = sensor if step is None else step.added_to(sensor)
    return sensor, tuple(steps)


def _shared(one: Grain, seen: Sequence[Grain]) -> float:
    """What the grain of a placement has in common with that of all others, in its native units squared."""
    return float(np.mean([one.common(other) for other in seen if other is not one]))


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
    return float(trim_mean(tiles.mean(np.where(inside, product, 0.0))[some] / share[some], TRIMMED))


def _patterns(patch: Patch) -> float:
    """Variance that patterns of which the model knows the usual size may leave in squares without their planes."""
    total = 0.0
    for effect in unknown_patterns(patch.sensor):
        if not effect.grain:
            drawn = [replace(patch.view, moment=replace(patch.view.moment, unit=unit)) for unit in range(UNITS)]
            with np.errstate(all="ignore"):
                images = [np.nan_to_num(effect.bias(patch.depth, view) * patch.native) for view in drawn]
            powers = [_usual(patch.tiles, _upright(patch, image) ** 2, patch.tiles.label >= 0) for image in images]
            total += WITHIN**2 * float(np.mean(powers))
    return total


def _power(effect: Effect | None, patch: Patch) -> float:
    """Mean square of an effect's grain in native units, as it is seen without the planes of the tiles."""
    if effect is None:
        return 0.0
    with np.errstate(all="ignore"):
        whole = float(np.median(patch.tiles.mean((effect.noise(patch.depth, patch.view) * patch.native) ** 2)))
    return whole * _kept(effect.window(patch.view), _side(patch))


def _side(patch: Patch) -> int:
    """Of the squares [px], as many pixels as are used of them."""
    return round(float(np.sqrt(np.median(patch.tiles.pixels))))


def _kept(window: float, side: int) -> float:
    """Share of the variance of pixels that share a window which a square's own mean and slopes leave."""
    steps = np.arange(side)
    alike = np.maximum(1.0 - np.abs(steps[:, None] - steps) / max(window, 1.0), 0.0)
    slope = steps - steps.mean()
    mean, slope = alike.sum() / side, slope @ alike @ slope / (slope @ slope)
    return float(1.0 - mean * (mean + 2 * slope) / side**2)


def _step(kind: type[Effect], sensor: Sensor, found: Vector, seen: Sequence[Grain]) -> ChannelStep | None:
    """An effect with as much grain as is found, where that is more than is stated; None where it is not."""
    size, *window = kind.grain
    known, noise = sensor.effect(kind.name), np.array([one.noise for one in seen])
    unit: dict[str, Any] = {size: 1.0}
    one, found = kind(**unit) if known is None else replace(known, **unit), found / noise

    def powers() -> Vector:
        return np.array([_power(one, grain.patch) for grain in seen]) / noise

    weights = powers() / powers().sum()
    share = float(weights @ found)

    def along(apart: Sequence[int]) -> float:
        return float(weights @ ([grain.along(apart) for grain in seen] / noise)) / share

    if share < LEAST_SHARE or abs(along(APART_PX)) > SHAPED:
        return None
    if window and known is None:
        wide: dict[str, Any] = {window[0]: _window(along((1,)), _side(seen[0].patch))}
        one = replace(one, **wide)
    power = powers()
    square = float(power @ found / (power @ power))
    spread = float(np.linalg.norm(found - square * power) / np.sqrt((len(seen) - 1) * (power @ power)))
    chance = float(student.sf((square - _stated(known, size, sensor)) / max(spread, 1e-300), len(seen) - 1))
    if chance > FALSE_ALARM:
        return None
    value = float(np.sqrt(square))
    fitted: dict[str, Any] = {size: min(value, parameters(kind)[size].high)}
    std, gain = {size: spread / (2 * value)}, float(found.sum())
    share = float(np.clip(gain / (np.array([grain.whole for grain in seen]) / noise).sum(), 0.0, 1.0))
    return ChannelStep(
        "bias", replace(one, **fitted), std, known is not None, gain, share, chance, text=TEXT[kind.anew]
    )


def _stated(known: Effect | None, size: str, sensor: Sensor) -> float:
    """Square of the largest size that goes with what is stated."""
    if known is None:
        return 0.0
    value = float(np.mean(getattr(known, size)))
    return (value + WITHIN * float(np.max(sensor.std.get((known.name, size), USUAL * value)))) ** 2


def _window(near: float, side: int) -> float:
    """Window [px] of which neighbours share so much, in squares without their means and slopes."""
    windows = np.linspace(1.0, APART_PX[0], 57)
    kept = np.array([_kept(window, side) for window in windows])
    return float(windows[np.argmin(np.abs((1.0 - 1.0 / windows - (1.0 - kept)) / kept - near))])
