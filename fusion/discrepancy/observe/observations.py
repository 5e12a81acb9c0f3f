"""Observations: what recordings show beyond the prediction of scene and sensor: tiles in native units."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.unrounded import STEP, Unrounded, next_level, rounding_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.interior import interior
from fusion.discrepancy.observe.outliers import foreign
from fusion.discrepancy.observe.placements import views_of
from fusion.discrepancy.observe.things import things
from fusion.discrepancy.observe.tiles import Tiling, tiling, usual_side
from fusion.recording.ahead import side_by_side
from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import rigid_motions
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.sensor.where import VARIABLES

MOST_TILES = 2800  # time grows with the third power: with more, tiles are larger; these take a minute on two cores
LARGEST_PX = 64
SERIES = 5  # blocks of one recording from which on its tiles are larger where they are many, to keep the numbers few


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
    """

    block: FrameBlock
    sensor: Sensor
    view: View
    predicted: Image
    sigma: Image
    native: Image
    tiles: Tiling
    steps: Unrounded | None = None

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


@dataclass(frozen=True)
class Observations:
    """All blocks of all recordings under one sensor model.

    Attributes:
        sensor: the model that predicted.
        patches: one per block.
        loose: sizes of errors that no law follows.
    """

    sensor: Sensor
    patches: tuple[Patch, ...]
    loose: Loose = field(default_factory=Loose)

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        return np.concatenate([patch.residual for patch in self.patches])

    @cached_property
    def place(self) -> NDArray[np.intp]:
        """(n,) recording of each tile."""
        return np.concatenate([np.full(len(patch.tiles), patch.block.place) for patch in self.patches])

    @cached_property
    def block_number(self) -> NDArray[np.intp]:
        """(n,) recording of each tile; the blocks of a long series count one by one."""
        number, out = len(self.patches), []
        for k, patch in enumerate(self.patches):
            series = sum(other.block.place == patch.block.place for other in self.patches) > SERIES
            out.append(np.full(len(patch.tiles), patch.block.place + (number * (k + 1) if series else 0)))
        return np.concatenate(out)

    @cached_property
    def replicate(self) -> NDArray[np.intp]:
        """(n,) recording of each tile; of one recording alone its view, as long as there are several."""
        places = {patch.block.place for patch in self.patches}
        views = views_of([patch.block.T_world_camera for patch in self.patches])
        if len(places) > 1 or len(set(views)) == 1:
            return self.place
        return np.concatenate([np.full(len(p.tiles), view) for p, view in zip(self.patches, views, strict=True)])

    @cached_property
    def variables(self) -> dict[str, NDArray[np.float64]]:
        """Tile means (n,) of all that is known of every tile and varies, by the names and in the units of verdicts."""
        out: dict[str, NDArray[np.float64]] = {}
        flight = self.patches[0].view.time_of_flight
        for name, of in VARIABLES.items():
            if name == "edge" or (name == "disparity" and flight):  # tiles keep clear of edges
                continue
            seen = [of(patch.depth, patch.view) for patch in self.patches]
            if all(value is not None and np.any(np.isfinite(value)) for value in seen):
                means = [p.tiles.mean(np.asarray(x, float)) for p, x in zip(self.patches, seen, strict=True)]
                values = np.concatenate(means)
                if np.ptp(values) > 1e-9 * (1 + np.abs(values).max()):
                    out[name] = values
        return out

    def rows(self) -> Iterator[tuple[slice, Patch]]:
        """Each patch and where its tiles stand in the vectors."""
        start = 0
        for patch in self.patches:
            yield slice(start, start + len(patch.tiles)), patch
            start += len(patch.tiles)

    def columns(self, effects: Sequence[Effect]) -> NDArray[np.float64]:
        """(n, k) what each effect changes."""
        if not effects:
            return np.zeros((len(self.residual), 0))

        def changed(patch: Patch) -> NDArray[np.float64]:
            return np.column_stack([patch.column(effect) for effect in effects])

        return np.concatenate(side_by_side(changed, self.patches))

    def under(self, sensor: Sensor) -> "Observations":
        """The same blocks and tiles, in the same units, under another sensor model."""
        if sensor is self.sensor:
            return self  # with all that is computed of it
        return replace(
            self, sensor=sensor, patches=tuple(side_by_side(lambda patch: patch.under(sensor), self.patches))
        )

    def seen_again(self, blocks: Sequence[FrameBlock]) -> "Observations":
        """The same tiles of blocks that differ in what is known of their poses only."""
        return replace(self, patches=tuple(replace(p, block=k) for p, k in zip(self.patches, blocks, strict=True)))

    @property
    def looseness(self) -> NDArray[np.float64]:
        """(n,) by how much scatter and drift are larger in the recording of each tile than usual."""
        uneven = self.loose.uneven
        return np.sqrt(uneven)[self.place] if uneven else np.ones(len(self.place))


def observe(sensor: Sensor, blocks: Sequence[FrameBlock], most: int | None = None) -> Observations:
    """Predict every block with a sensor model and cut it into tiles, about `most` (`MOST_TILES`) of them."""
    most = most or MOST_TILES
    many = {block.place for block in blocks if sum(other.place == block.place for other in blocks) > SERIES}
    seen = [_patch(sensor, block) for block in blocks]
    usual = usual_side(blocks[0].mean.shape)
    usable = [_usable(patch) & ~strange for patch, strange in zip(seen, things(seen), strict=True)]
    patches = [replace(p, tiles=tiling(inside)) for p, inside in zip(seen, usable, strict=True)]
    if many and sum(len(patch.tiles) for patch in patches) > most // 4:  # of a small thing fewer would be none
        sides = [usual * (1 + (block.place in many)) for block in blocks]
        patches = [replace(p, tiles=tiling(u, side)) for p, u, side in zip(seen, usable, sides, strict=True)]
    start, side, count = patches, usual, sum(len(patch.tiles) for patch in patches)
    while count > most and side < LARGEST_PX:
        # no larger than they must be: what swings within a tile is not seen
        side = min(max(side + 1, int(side * np.sqrt(count / most))), LARGEST_PX)
        patches = [replace(p, tiles=tiling(p.tiles.label >= 0, p.tiles.side // usual * side)) for p in start]
        count = sum(len(patch.tiles) for patch in patches)
    return Observations(sensor, tuple(patches))


def _patch(sensor: Sensor, block: FrameBlock) -> Patch:
    """A block without tiles."""
    depth = block.view.depth
    assert depth is not None
    view, seen = sensor.seen(block.view), predicted(sensor, block)
    with np.errstate(all="ignore"):
        native = view.stretch if view.time_of_flight else -view.focal_baseline / seen.mean**2
    return Patch(block, sensor, view, seen.mean, seen.sigma, native, tiling(np.zeros(depth.shape, bool)), seen.steps)


def _usable(patch: Patch) -> NDArray[np.bool_]:
    """Pixels (h, w) that are seen, away from edges, of what the mesh has."""
    mean, count, frames = patch.block.mean, patch.block.count, len(patch.block.frames)
    usable = np.isfinite(patch.predicted) & np.isfinite(mean) & (count >= max(1, frames - 1)) & interior(patch.view)
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
