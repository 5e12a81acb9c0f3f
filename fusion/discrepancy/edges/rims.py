"""Rims: what is seen across the known depth edges of a block, as profiles: tiles keep clear of them.

Depths count in units of the gap: 0 is the near side, 1 the far one. The recorded profile is what it is; where exactly
the edge stands is not known, so predictions are made for edges that are moved.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.edges.filtered import filtered
from fusion.discrepancy.observe.outliers import foreign
from fusion.discrepancy.observe.patch import Patch
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, Image, View

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

REACH_PX, CALM_PX = 8.0, 6.0  # how far edges are known, and from where on a side is its own level
BIN_PX = 0.5
BINS = int(2 * CALM_PX / BIN_PX)  # of a profile, the near side first
SIDES = 8  # where the far side lies: to the right, below, to the left, above; each in two halves along the edge
FEWEST = 6  # pixels of a bin
SEEN = 0.5  # of the pixels of a bin that have a value: fewer are chosen, not seen
LEAST_GAP = 0.02  # of the depth: less is no edge
SAME_SIDE = 0.5  # of a gap: a neighbour that is farther off is on the other side
CLEAR = 10.0  # standard deviations of a pixel that a gap must have at least


class Displaced(NamedTuple):
    """How far edges stand from where they are said to: to the right and down [px], turned about the axis [rad], and
    away from the near thing [px m] over its depth."""

    u: float = 0.0
    v: float = 0.0
    roll: float = 0.0
    outline: float = 0.0


@dataclass(frozen=True)
class Rims:
    """The pixels beside the edges of one block.

    Attributes:
        patch: whose.
        label: (h, w) number of the bin of a pixel, -1 without one.
        calm: (h, w) number of the side (two for each direction) that a pixel tells the level of, -1 without one.
        near, gap: (h, w) depth [m] of the near side, and how much farther the far one is.
        side, at: (n,) direction and half, and signed distance [px] of a bin, positive on the far side.
        normal: (n, 3) mean direction to the far side (u, v), and how far a turn about the axis moves it there [px].
        depth: (n,) [m] of the near side.
    """

    patch: Patch
    label: NDArray[np.intp]
    calm: NDArray[np.intp]
    near: Image
    gap: Image
    side: NDArray[np.intp]
    at: Vector
    normal: NDArray[np.float64]
    depth: Vector

    def __len__(self) -> int:
        return len(self.at)

    @cached_property
    def _used(self) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
        used, calm = np.flatnonzero(self.label >= 0), np.flatnonzero(self.calm >= 0)
        return used, self.label.ravel()[used], calm, self.calm.ravel()[calm]

    def profiles(self, mean: Image, sigma: Image) -> Matrix:
        """(3, n) of a mean and a spread (h, w) [m]; each side less what it is off away from the edge.

        The place between both sides; how much its pixels are between them and not on one side, share (1 - share), which
        a displaced edge leaves as it is; and the variance of repeated frames in squared gaps.
        """
        return np.array([self._means(values) for values in self._in_gaps(mean, sigma)])

    @cached_property
    def recorded(self) -> Matrix:
        return self.profiles(self.patch.block.mean, self.patch.block.std)

    @cached_property
    def doubt(self) -> Matrix:
        """(3, n) standard deviations of what is recorded, by the scatter of the pixels in each bin."""
        number = self._used[1]
        count = np.bincount(number, minlength=len(self))
        parts = self._in_gaps(self.patch.block.mean, self.patch.block.std)
        squares = [self._means((part - mean[number]) ** 2) for part, mean in zip(parts, self.recorded, strict=True)]
        return np.asarray(np.sqrt(np.array(squares) / np.maximum(count - 1, 1)))

    @cached_property
    def shaken(self) -> Vector:
        """(n,) standard deviation [px] of what edges of the direction of each bin move together from frame to frame.

        Of pixels that jump each for itself as much as their number lets a mean wander is no common motion.
        """
        block, out = self.patch.block, np.zeros(len(self))
        recording = getattr(block.stage, "recording", None)
        if recording is None or len(block.frames) < 2:
            return out
        frames = (np.where(np.isfinite(depth := recording[i].depth), depth, block.mean) for i in block.frames)
        places = np.array([self._means(self._in_gaps(frame, block.std)[0]) for frame in frames])
        alone = self.recorded[2] / np.bincount(self._used[1], minlength=len(self))
        for axis in (0, 1):
            beyond = []
            for side in np.unique(self.side[self.side // 2 % 2 == axis]):
                own = self.side == side
                beyond.append(np.var(BIN_PX * places[:, own].sum(axis=1), ddof=1) - BIN_PX**2 * alone[own].sum())
            out[self.side // 2 % 2 == axis] = np.sqrt(max(float(np.mean(beyond)), 0.0)) if beyond else 0.0
        return out

    def _in_gaps(self, mean: Image, sigma: Image) -> tuple[Vector, Vector, Vector]:
        used, number, calm, level = self._used
        own = 2 * self.side[number] + (self.at[number] > 0)
        place = ((mean - self.near) / self.gap).ravel()
        square = np.square(sigma / self.gap).ravel()
        share = place[used] - _levels(place[calm] - level % 2, level)[own]
        return share, share * (1 - share), square[used] - _levels(square[calm], level)[own]

    def _means(self, values: Vector) -> Vector:
        number = self._used[1]
        total = np.bincount(number, weights=np.nan_to_num(values), minlength=len(self))
        return np.asarray(total / np.maximum(np.bincount(number, minlength=len(self)), 1))

    def predicted(self, sensor: Sensor, moved: Displaced, window: float = 0.0) -> Matrix:
        """(3, n) what a sensor says where the edges stand elsewhere, behind a filter [px^2] of each frame.

        What else a sensor does to a side is taken out with the level of the side.
        """
        view = with_edges_at(self.patch.view, moved)
        assert view.depth is not None
        acting = replace(sensor, effects=tuple(effect for effect in sensor.effects if acts_at_edges(type(effect))))
        with np.errstate(all="ignore"):
            place, between, square = self.profiles(*filtered(*acting.repeated(view.depth, view), window))
        # pixels that jump are on one side in each of the few frames
        return np.array([place, between - square / len(self.patch.block.frames), square])


def _slid(depth: Image, where: NDArray[np.intp], jump: Vector, shift: Vector, axis: int) -> Vector:
    """(n,) by how much pixels see another depth of their own side when all that is seen slides by `shift` [px]."""
    steps = np.diff(depth, axis=axis)
    first, last = ([(0, 0), (0, 0)] for _ in range(2))
    first[axis], last[axis] = (1, 0), (0, 1)
    before, after = (np.pad(steps, ends, constant_values=np.nan).ravel()[where] for ends in (first, last))
    # what slides in; where that is the other side or not in the image, what slides out
    ways = np.where(shift > 0, (before, after), (after, before))
    ways = np.where(np.abs(ways) < SAME_SIDE * jump, ways, np.nan)
    return -shift * np.nan_to_num(np.where(np.isfinite(ways[0]), ways[0], ways[1]))


def _levels(values: Image, level: NDArray[np.intp]) -> Vector:
    """(2 SIDES,) mean of the values (k,) of each level, where there are any."""
    known = np.isfinite(values)
    total = np.bincount(level[known], weights=values[known], minlength=2 * SIDES)
    return np.asarray(total / np.maximum(np.bincount(level[known], minlength=2 * SIDES), 1))


def acts_at_edges(kind: type[Effect]) -> bool:
    """True of an effect that makes something else of a depth edge, also of one that stands still."""
    acts = kind.changes("bias") or kind.changes("noise")
    return acts and "edge" in kind.variables and "velocity" not in kind.variables


def rims_of(patch: Patch) -> Rims | None:
    """The rims of a block; None where no edge of a known place is seen by a camera that stands still."""
    view, block = patch.view, patch.block
    edges, depth = view.edges, patch.depth
    if edges is None or not np.any(edges.distance < REACH_PX) or len(block.frames) < 2 or block.given is not None:
        return None
    if block.stage.reconstructed or block.stage.table is not None:
        return None
    with np.errstate(all="ignore"):
        jump = np.where(edges.distance < REACH_PX, edges.jump, 0.0)
        near, gap = depth + np.minimum(jump, 0.0), np.abs(jump)
        beside = (gap > LEAST_GAP * near) & (gap > CLEAR * np.nan_to_num(patch.sigma)) & np.isfinite(depth)
    if not beside.any():
        return None
    far = jump < 0
    # of a far pixel the edge lies towards the near thing
    angle = edges.direction + np.where(far, np.pi, 0.0)
    x, y = np.broadcast_arrays(view.u - view.camera.cx, view.v - view.camera.cy)
    side = np.rint(angle / (np.pi / 2)).astype(np.intp) % 4
    side = 2 * side + (np.where(side % 2, x, y) > 0)
    signed = np.where(far, edges.distance, -edges.distance)
    strange = foreign(np.where(edges.distance < REACH_PX, np.nan, block.mean), patch.predicted, depth)
    there = beside & ~strange
    seen = there & np.isfinite(block.mean) & (block.count >= max(1, len(block.frames) - 1))
    bins = np.floor((signed + CALM_PX) / BIN_PX)
    inside = (bins >= 0) & (bins < BINS)
    number = np.where(inside, side * BINS + np.nan_to_num(bins), 0).astype(np.intp)
    every = SIDES * BINS
    could, count = (np.bincount(number[inside & part], minlength=every) for part in (there, seen))
    kept = (count >= FEWEST) & (count >= SEEN * could)
    calm = np.where(seen & (edges.distance >= CALM_PX), 2 * side + far, -1)
    levels = np.bincount(calm[calm >= 0], minlength=2 * SIDES) >= FEWEST
    place = np.arange(every)
    at = np.asarray((place % BINS + 0.5) * BIN_PX - CALM_PX, float)
    kept &= levels[2 * (place // BINS) + (at > 0)]
    if not kept.any():
        return None
    label = np.where(inside & seen & kept[number], (np.cumsum(kept) - 1)[number], -1)
    cos, sin, used = np.cos(angle), np.sin(angle), label >= 0
    mean = [np.bincount(label[used], weights=image[used]) for image in (cos, sin, x * sin - y * cos, near)]
    total = np.bincount(label[used])
    return Rims(patch, label, calm, near, np.where(gap > 0, gap, np.nan), (place // BINS)[kept], at[kept],
                np.column_stack(mean[:3]) / total[:, None], mean[3] / total)  # fmt: skip


def with_edges_at(view: View, moved: Displaced) -> View:
    """A view whose edges stand elsewhere; what they leave or reach changes the side."""
    edges, depth = view.edges, view.depth
    assert edges is not None and depth is not None
    if not any(moved):
        return view
    where = np.flatnonzero(np.isfinite(edges.distance) & np.isfinite(edges.jump) & (edges.jump != 0))
    own, distance, direction, jump, light = (
        image.ravel()[where] for image in (depth, edges.distance, edges.direction, edges.jump, edges.light)
    )
    y, x = np.divmod(where, depth.shape[1])
    u, v = moved.u - moved.roll * (y - view.camera.cy), moved.v + moved.roll * (x - view.camera.cx)
    away = np.where(jump > 0, moved.outline, -moved.outline) / np.maximum(own + np.minimum(jump, 0), 1e-3)
    distance = distance + u * np.cos(direction) + v * np.sin(direction) + away
    across, along = distance < 0, np.abs(jump)
    own = own + sum(_slid(depth, where, along, shift, axis) for axis, shift in ((1, u), (0, v)))
    with np.errstate(all="ignore"):
        seen = (
            np.where(across, own + jump, own),
            np.abs(distance),
            np.where(across, direction + np.pi, direction),
            np.where(across, -jump, jump),
            np.where(across, 1 / light, light),
        )
    images = [image.copy() for image in (depth, edges.distance, edges.direction, edges.jump, edges.light)]
    for image, values in zip(images, seen, strict=True):
        image.flat[where] = values
    return replace(view, depth=images[0], edges=Edges(*images[1:]))
