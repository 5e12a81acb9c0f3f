"""Wrapping: ranges that lost whole turns of the phase, told before any law is asked: turns are counted, not fitted.

That a recording shows another scene, or poses are wrong, would put what is missing to a range at random; each view in
which it is a whole number of turns, and of those turns that the range should have lost, is a coincidence less likely.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.decisions import FALSE_ALARM
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, MODULATIONS_HZ

Vector = NDArray[np.float64]

# that takes whole lengths of its `range` off what is farther
WRAPS = next(kind for kind in EFFECTS if "range" in {field.name for field in fields(kind)})
NEAR = 0.03  # [m] to whole turns: how far a range that lost them is off for other reasons
SHORTEST = 0.3  # [m] of a turn, that of 500 MHz: no depth camera's is shorter
MOST_TURNS = 3  # that a median may have lost, where no modulation is known
HOLDS = 0.9  # of all pixels, that must be where the turns put them (guess: the rest is what stands before the wall)
SEEN = 0.01  # of a view's pixels from which on a number of turns counts as seen in it (guess)


@dataclass(frozen=True)
class Wrapping:
    """The longest range that is told apart, and how well that explains ranges that are far too short."""

    effect: Effect
    length: float  # its range [m]
    std: float  # of its range [m]
    share: float  # of the squares of all errors of range that it explains
    gain: float  # these squares less what is left, in units of `NEAR`
    probability: float  # that ranges which are wrong for any other reason lie so

    @property
    def step(self) -> ChannelStep:
        """As what is told first."""
        established = self.probability <= FALSE_ALARM
        std, text = {"range": self.std}, "ranges are short by whole turns of the phase, and by those beyond them"
        return ChannelStep("bias", self.effect, std, False, self.gain, self.share, self.probability, text=text,
                           established=established)  # fmt: skip

    def added_to(self, sensor: Sensor) -> Sensor:
        """The sensor with it, known as well as the recordings tell it: laws are asked for beside what that leaves."""
        return replace(sensor.having(self.effect), std={**sensor.std, (self.effect.name, "range"): self.std})


def wrapping_of(blocks: Sequence[FrameBlock], sensor: Sensor) -> Wrapping | None:
    """How ranges wrap that a model does not wrap; None where they do not, or something else may do the same.

    Args:
        blocks: of known scenes.
        sensor: its modulations are tried first; where it has none, those that are usual and any other.
    """
    held = sensor.effect(WRAPS.name)
    if sensor.principle != Principle.TIME_OF_FLIGHT or held is not None:
        return None
    views = [view for block in blocks if len((view := _ranges(block))[0])]
    if not views or not any(np.mean(lost > SHORTEST / 2) > SEEN for _, lost in views):
        return None
    known = LIGHT_SPEED / (2 * np.asarray(sensor.frequencies or MODULATIONS_HZ))
    tried = [*((float(length), True) for length in known), *((length, False) for length in _unknown(views))]
    found = [one for length, told in tried if (one := _wrapping(views, length, told, len(tried))) is not None]
    return min(found, key=lambda one: one.probability, default=None)


def clear_of_turns(blocks: Sequence[FrameBlock], wrapping: Wrapping) -> list[FrameBlock]:
    """The blocks without pixels so near to a whole turn that noise and pose decide on which side they fall."""
    return [_clear(block, wrapping.length) for block in blocks]


def _clear(block: FrameBlock, length: float) -> FrameBlock:
    assert block.view.depth is not None
    ranges = block.view.depth * block.view.stretch
    whole = np.round(ranges / length)
    unsure = (np.abs(ranges - whole * length) < NEAR) & (whole > 0)
    held = None if block.held is None else _clear(block.held, length)
    return replace(block, mean=np.where(unsure, np.nan, block.mean), std=np.where(unsure, np.nan, block.std), held=held)


def _ranges(block: FrameBlock) -> tuple[Vector, Vector]:
    """(n,) [m] ranges of what stood before the pixels that saw something, and what of them is missing."""
    depth = block.view.depth
    if depth is None:
        return np.zeros(0), np.zeros(0)
    lost = (depth - block.mean) * block.view.stretch
    seen = np.isfinite(lost)
    return (depth * block.view.stretch)[seen].astype(float), lost[seen].astype(float)


def _unknown(views: Sequence[tuple[Vector, Vector]]) -> Iterator[float]:
    """Lengths [m] of a turn that what is missing may be one, two or three of."""
    for _, lost in views:
        gone = lost[lost > SHORTEST / 2]
        if len(gone) > SEEN * len(lost):
            yield from (one for k in range(1, MOST_TURNS + 1) if (one := float(np.median(gone)) / k) > SHORTEST)


def _wrapping(views: Sequence[tuple[Vector, Vector]], length: float, known: bool, tried: int) -> Wrapping | None:
    """A length of a turn, fitted and judged; None where most ranges are not where it puts them."""
    every = np.concatenate([lost for _, lost in views])
    turns = np.round(every / length)
    held = (turns > 0) & (np.abs(every - turns * length) < NEAR)
    if not held.any():
        return None
    own = every[held] / turns[held]
    length, std = float(np.median(own)), float(own.std() / np.sqrt(len(views)))  # of a view all are off alike
    coincidences, before, after = 0, [], []
    for ranges, lost in views:
        expected = np.floor(ranges / length)
        inside = np.abs(ranges - np.round(ranges / length) * length) > NEAR
        before.append(lost[inside])
        after.append((lost - expected * length)[inside])
        fits = inside & (np.abs(lost - expected * length) < NEAR)
        counts = [np.mean(fits & (expected == k)) > SEEN for k in range(int(expected.max()) + 1)]
        coincidences += sum(counts) if any(counts[1:]) else 0  # that what lost no turn is right tells where they begin
    left, whole = np.concatenate(after), float(np.square(np.concatenate(before)).sum())
    if not coincidences or np.mean(np.abs(left) < NEAR) < HOLDS:
        return None
    gone = whole - float(np.square(left).sum())
    chance = min(1.0, tried * (2 * NEAR / length) ** max(coincidences - (not known), 0))
    if not known and chance > FALSE_ALARM:
        return None  # a pose that is wrong does the same
    wraps: dict[str, Any] = {"range": length}
    return Wrapping(WRAPS(**wraps), length, std, gone / whole, gone / NEAR**2, chance)
