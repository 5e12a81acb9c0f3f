"""Observations: what recordings show beyond the prediction of scene and sensor: tiles in native units."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.observe.frame_block import TOGETHER_S, FrameBlock
from fusion.discrepancy.observe.frames import REACH_PX, likeness, local_mean
from fusion.discrepancy.observe.patch import Patch, patch_of, usable_in
from fusion.discrepancy.observe.placements import views_of
from fusion.discrepancy.observe.things import things
from fusion.discrepancy.observe.tiles import tiling, usual_side
from fusion.recording.ahead import side_by_side
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import VARIABLES

MOST_TILES = 2800  # time grows with the third power: with more, tiles are larger; these take a minute on two cores
LARGEST_PX = 64
SERIES = 5  # blocks of one recording from which on its tiles are larger where they are many, to keep the numbers few


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
        """(n,) recording of each tile; of a long series what is taken together in time counts one by one."""
        number, out = len(self.patches), []
        for patch in self.patches:
            times = [other.view.moment.time for other in self.patches if other.block.place == patch.block.place]
            late = int((patch.view.moment.time - min(times)) // TOGETHER_S) if len(times) > SERIES else -1
            out.append(np.full(len(patch.tiles), patch.block.place + number * (late + 1)))
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
    seen = [patch_of(sensor, block) for block in blocks]
    usual = usual_side(blocks[0].mean.shape)
    usable = [usable_in(patch) & ~strange for patch, strange in zip(seen, things(seen), strict=True)]
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
    return Observations(sensor, tuple(_with_likeness(patches)))


def _with_likeness(patches: Sequence[Patch]) -> Sequence[Patch]:
    """Blocks of single frames with how alike the noise of neighbours is, as what is rough in their residuals has it."""
    rough, alone = [], [len(patch.block.frames) == 1 and patch.block.alike is None for patch in patches]
    for patch, single in zip(patches, alone, strict=True):
        if single and patch.unrounded is None:
            off = np.where(patch.tiles.label >= 0, (patch.block.mean - patch.predicted) * patch.native, np.nan)
            rough.append(off - local_mean(off))
    if not rough:
        return patches
    alike = likeness(*rough)  # of all together: in one image it may be chance
    far = alike[:, REACH_PX // 2 + 1 :].mean(axis=1, keepdims=True)  # of laws within a square, and of the mean's taking
    alike = np.where(np.arange(REACH_PX + 1) > REACH_PX // 2, 0.0, (alike - far) / (1.0 - far))
    return [replace(p, shared=alike) if single else p for p, single in zip(patches, alone, strict=True)]
