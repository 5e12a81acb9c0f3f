"""Patch: a stretch of frames from one place under a sensor model, cut into tiles, in native units."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.unrounded import STEP, Unrounded, next_level, rounding_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.interior import interior
from fusion.discrepancy.observe.outliers import foreign
from fusion.discrepancy.observe.tiles import Tiling, tiling
from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import rigid_motions
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Patch:
    """One block, cut into tiles.

    Attributes:
        block: what was measured.
        sensor: the model that predicted.
        view: what stood there, as the sensor needs it.
        predicted, sigma: (h, w) [m] of repeated frames by the sensor model.
        native: (h, w) native units (m along the ray, or px of disparity) per metre of depth.
        tiles: which pixels are used.
        steps: what is rounded; None by a model without steps.
        shared: (2, k) correlation of the noise of pixels 0, 1, ... apart along u and along v, as residuals of single
            frames have it.
    """

    block: FrameBlock
    sensor: Sensor
    view: View
    predicted: Image
    sigma: Image
    native: Image
    tiles: Tiling
    steps: Unrounded | None = None
    shared: NDArray[np.float64] | None = None

    @property
    def alike(self) -> NDArray[np.float64] | None:
        """(2, k) correlation of the noise of neighbours, of frames that follow each other where there are any."""
        return self.shared if self.block.alike is None else self.block.alike

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        """(n,) mean of measured less predicted, in native units; less what is not linear in the error of the pose."""
        return self.tiles.mean((self.block.mean - self.predicted - self.block.moved_beyond) * self.native)

    @property
    def depth(self) -> Image:
        """(h, w) true depth [m]."""
        assert self.view.depth is not None
        return self.view.depth

    def column(self, effect: Effect) -> NDArray[np.float64]:
        """(n,) by how much an effect changes the tiles, to first order, in native units."""
        return self.tiles.mean(self.change(effect))

    def change(self, effect: Effect) -> Image:
        """By how much (h, w) an effect changes what is seen behind the rounding, to first order, in native units."""
        with np.errstate(all="ignore"):
            first, *others = frame_views(self.block, self.view, (effect,))
            mean = effect.change(self.depth, first)
            if others:
                mean = np.mean([mean, *(effect.change(self.depth, one) for one in others)], axis=0)
            return np.asarray(mean * self.native * self._passed)

    @cached_property
    def unrounded(self) -> Unrounded | None:
        """What is rounded; None by a model without steps, or where noise hides them."""
        return self.steps if self.steps is not None and self.steps.shows(self.tiles.label >= 0) else None

    @cached_property
    def _passed(self) -> Image | float:
        return 1.0 if self.unrounded is None else self.unrounded.passed(self.view)

    @cached_property
    def step(self) -> float:
        """Usual step of the rounding in native units; 0 without."""
        if self.steps is None:
            return 0.0
        with np.errstate(all="ignore"):
            lost = np.nanmedian(np.abs(self.steps.rounding.noise(self.depth, self.view) * self.native))
        return float(STEP * lost)

    @property
    def next_level(self) -> Image | float:
        """(h, w) [m] by which rounding to another step does not move a pixel; 0 by a model without steps."""
        return next_level(self.sensor, self.predicted, self.view.camera)

    @cached_property
    def usual_native(self) -> float:
        """Usual size of the native units per metre, over the tiles; NaN without."""
        return float(np.median(np.abs(self.native[self.tiles.label >= 0])))

    @cached_property
    def told(self) -> tuple[Image, NDArray[np.float64]]:
        """(h, w) squared native units per squared metre, 0 where no spread is predicted or measured; and the share
        (n,) of pixels where both are."""
        sound = np.isfinite(self.block.std) & np.isfinite(self.sigma)
        return np.where(sound, self.native**2, 0.0), np.maximum(self.tiles.mean(sound.astype(float)), 1e-9)

    @cached_property
    def motions(self) -> NDArray[np.float64]:
        """(6, n) native units: all that is seen turned about each axis by a radian, and shifted along it by a metre."""
        return np.stack([self.tiles.mean(change * self.native) for change in rigid_motions(self.depth, self.view)])

    def under(self, sensor: Sensor) -> "Patch":
        """The same tiles, in the same units, under another sensor model."""
        seen = predicted(sensor, self.block)
        return replace(self, sensor=sensor, predicted=seen.mean, sigma=seen.sigma, steps=seen.steps)


def patch_of(sensor: Sensor, block: FrameBlock) -> Patch:
    """A block without tiles."""
    depth = block.view.depth
    assert depth is not None
    view, seen = sensor.seen(block.view), predicted(sensor, block)
    with np.errstate(all="ignore"):
        native = view.stretch if view.time_of_flight else -view.focal_baseline / seen.mean**2
    return Patch(block, sensor, view, seen.mean, seen.sigma, native, tiling(np.zeros(depth.shape, bool)), seen.steps)


def usable_in(patch: Patch) -> NDArray[np.bool_]:
    """Pixels (h, w) that are seen, away from edges, of what the mesh has."""
    mean, count, frames = patch.block.mean, patch.block.count, len(patch.block.frames)
    usable = np.isfinite(patch.predicted) & np.isfinite(mean) & (count >= max(1, frames - 1)) & interior(patch.view)
    if patch.view.bent is not None:  # how a sensor weighs what a pixel sees is known as well as a single frame tells
        noise = np.fmax(patch.sigma, patch.block.std)
        usable &= ~(patch.view.bent > np.where(noise > 0, noise, np.inf))
    return np.asarray(usable & ~foreign(mean, patch.predicted, patch.depth, patch.next_level))


class Predicted(NamedTuple):
    """Mean and standard deviation (h, w) [m] of repeated frames; what is rounded, None by a model without steps."""

    mean: Image
    sigma: Image
    steps: Unrounded | None


def predicted(sensor: Sensor, block: FrameBlock) -> Predicted:
    """What a sensor model says of a block.

    How steps of rounding show in the mean is told by the noise that the frames have, whatever the model says of it.
    """
    depth, steps = block.view.depth, None
    assert depth is not None
    rounding = rounding_of(sensor)
    others = tuple(effect for effect in sensor.effects if effect is not rounding)
    before = replace(sensor, effects=others)
    means, sigmas = zip(*[before.repeated(depth, one) for one in frame_views(block, block.view, others)], strict=True)
    # what swings from frame to frame is a part of their spread
    mean, sigma = np.mean(means, axis=0), np.hypot(np.sqrt(np.mean(np.square(sigmas), axis=0)), np.std(means, axis=0))
    if rounding is not None:
        view = sensor.seen(block.view)
        steps = Unrounded.of(sensor, rounding, mean, sigma, block.std, view)
        with np.errstate(all="ignore"):
            whole, sigma = rounding.repeated(mean, sigma, view)
        mean = steps.rounded(view) if steps.shows(np.isfinite(mean)) else whole
    if block.given is None:
        return Predicted(mean, sigma, steps)
    spread = sigma if block.given.spread is None else np.hypot(sigma, block.given.spread)
    return Predicted(mean + block.given.offset, spread, steps)


def frame_views(block: FrameBlock, view: View, effects: Sequence[Effect]) -> list[View]:
    """A view of a block at the time of each of its frames, where an effect swings the depth; else the one of all."""
    times = block.times if any(map(_swings, effects)) else ()
    return [replace(view, moment=replace(view.moment, time=time)) for time in times] or [view]


def _swings(effect: Effect) -> bool:
    """True of an effect that swings the depth: it has a frequency in time."""
    return effect.changes("bias") and any(about.unit == "Hz" for about in parameters(effect).values())
