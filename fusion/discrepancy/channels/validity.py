"""Validity: which share of the values of every tile is missing, against what a sensor model says of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.interior import interior, reach
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.observe.tiles import tiling
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.simulation.rendering.casting import Body, CastBodies
from fusion.simulation.rendering.shadow import lit_of

Vector = NDArray[np.float64]

RIM_PX = 12.0  # from a depth edge: wider than the shadows of usual steps at usual distances
FINER = 4  # squares beside an edge, so that its two sides are told apart
LEAST_LOST = 0.05  # of the values of the tiles that change most: less is told of none
FLOOR = 0.02  # of a tile's pixels: what a model of validity leaves open, from recordings in which nothing is missing


@dataclass(frozen=True)
class Validity:
    """Missing shares of tiles (n,), which hold the pixels that a surface stands before, seen or not."""

    patches: tuple[Patch, ...]  # with tiles of their own
    missing: Vector  # measured share
    predicted: tuple[Image, ...]  # (h, w) per patch, probability by the model
    place: NDArray[np.intp]  # recording of each tile

    def share(self, effect: Effect | None = None, less: Effect | None = None, exact: bool = False) -> Vector:
        """(n,) predicted share with one more effect, and without one that the model holds.

        Args:
            exact: where its light falls is asked of the scene itself: pixels see where a shadow ends to a pixel only.
        """
        parts = []
        for patch, lost in zip(self.patches, self.predicted, strict=True):
            seen = 1.0 - lost
            with np.errstate(all="ignore"):
                if less is not None:
                    own = np.asarray(less.dropout(patch.depth, patch.view))
                    seen = np.where(own < 1, seen / np.maximum(1 - own, 1e-6), _others(patch, less))
                if effect is not None:
                    view = replace(patch.view, lit=_lit(patch, effect)) if exact else patch.view
                    seen = seen * (1.0 - effect.dropout(patch.depth, view))
            parts.append(patch.tiles.mean(1.0 - seen))
        return np.concatenate(parts)

    def sigma(self, share: Vector) -> Vector:
        """(n,) standard deviation of the measured share where `share` is expected: every pixel decides for itself."""
        pixels = np.concatenate([patch.tiles.pixels for patch in self.patches])
        return np.sqrt(np.clip(share * (1 - share), 0.0, 0.25) / pixels + FLOOR**2)

    def exact(self, effect: Effect) -> bool:
        """True where the scene can be asked where the light of an effect falls."""
        return effect.lit_from() is not None and all(p.block.stage.caster is not None for p in self.patches)

    @property
    def observations(self) -> Observations:
        return Observations(self.patches[0].sensor, self.patches)


def validity_of(sensor: Sensor, patches: Sequence[Patch]) -> Validity | None:
    """The validity of blocks; None when no tile is left."""
    used = []
    for patch in patches:
        view, block = sensor.seen(patch.block.view), patch.block
        usable = np.isfinite(patch.depth) & interior(view)
        # where no amplitude is recorded, no model knows what is too dark for good: only what comes and goes is judged
        used.append((view, usable if block.view.ir is not None else usable & (block.count > 0)))
    return _validity(sensor, patches, used, 1)


def validity_of_rims(sensor: Sensor, patches: Sequence[Patch]) -> Validity | None:
    """The same of what lies beside depth edges, which no projector is taken to light yet."""
    used = []
    for patch in patches:
        view = replace(sensor.seen(patch.block.view), lit=None)
        rim = reach(RIM_PX, view.camera.width)
        near = np.zeros(patch.depth.shape, bool) if view.edges is None else view.edges.distance < rim
        used.append((view, np.isfinite(patch.depth) & near))
    return _validity(sensor, patches, used, FINER)


def _validity(
    sensor: Sensor, patches: Sequence[Patch], used: Sequence[tuple[View, NDArray[np.bool_]]], finer: int
) -> Validity | None:
    kept, missing, predicted, place = [], [], [], []
    for patch, (view, usable) in zip(patches, used, strict=True):
        block, tiles = patch.block, tiling(usable, patch.tiles.side // finer)
        if len(tiles):
            kept.append(replace(patch, sensor=sensor, view=view, tiles=tiles))
            missing.append(tiles.mean(_lost(block)))
            lost = _predicted(sensor, block)
            predicted.append(np.broadcast_to(lost, patch.depth.shape))
            place.append(np.full(len(tiles), block.place))
    if not kept:
        return None
    return Validity(tuple(kept), np.concatenate(missing), tuple(predicted), np.concatenate(place))


def _predicted(sensor: Sensor, block: FrameBlock) -> Image:
    """(h, w) chance that a value is missing; a simulation knows it for all that its own model holds."""
    assert block.view.depth is not None
    if block.given is None:
        return sensor.dropout(block.view.depth, block.view)
    added = tuple(effect for effect in sensor.effects if effect not in block.given.model.effects)
    more = replace(sensor, effects=added).dropout(block.view.depth, block.view)
    return 1.0 - (1.0 - block.given.lost) * (1.0 - more)


def _lit(patch: Patch, effect: Effect) -> Image:
    """Share (h, w) of each pixel of the tiles that the light of an effect reaches in the scene."""
    block, x = patch.block, effect.lit_from()
    assert x is not None and block.stage.caster is not None and block.view.normals is not None
    view = replace(block.view, depth=np.where(patch.tiles.label >= 0, patch.depth, np.nan))
    return lit_of(view, block.view.normals, CastBodies((Body(block.stage.caster),), block.T_world_camera), x)


def _lost(block: FrameBlock) -> Image:
    return 1.0 - block.count / max(len(block.frames), 1)


def _others(patch: Patch, less: Effect) -> Image:
    """(h, w) chance that a pixel has a value, by all effects but one."""
    rest = replace(patch.sensor, effects=tuple(e for e in patch.sensor.effects if e.name != less.name))
    return 1.0 - np.broadcast_to(rest.dropout(patch.depth, patch.block.view), patch.depth.shape)
