"""Scatter: how repeated frames scatter on every tile, against what a sensor model says of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.succession import memory_of, succession_of
from fusion.discrepancy.observe.patch import Patch

Vector = NDArray[np.float64]

LEAST_VARIANCE = 1e-14  # in native units: of a model without noise
WANDERS = 4.0  # of the logarithm of a variance that rounding alone makes
FLOOR = 0.03  # of a variance: what the model of the noise leaves open, from recordings in which nothing is missing


@dataclass(frozen=True)
class Scatter:
    """The noise of tiles (n,)."""

    patches: tuple[Patch, ...]  # whose tiles, in order
    excess: Vector  # logarithm of the measured over the predicted variance of repeated frames
    excess_sigma: Vector  # its standard deviation, from the number of pixels that are independent in effect
    # logarithm of the variance that is new in every frame over the whole one, less what is predicted; 0 where the
    # frames say nothing about it
    renewal: Vector
    renewal_sigma: Vector  # its standard deviation; infinite there
    place: NDArray[np.intp]  # recording of each tile

    def __len__(self) -> int:
        return len(self.excess)

    def only(self, rows: NDArray[np.bool_]) -> "Scatter":
        """These tiles alone."""
        noise = (self.excess[rows], self.excess_sigma[rows], self.renewal[rows], self.renewal_sigma[rows])
        return Scatter(self.patches, *noise, self.place[rows])


def scatter_of(patches: Sequence[Patch]) -> Scatter:
    """The scatter of blocks of two frames and more."""
    rows = [_scatter(patch) for patch in patches]
    excess, excess_sigma, renewal, renewal_sigma = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    place = np.concatenate([np.full(len(patch.tiles), patch.block.place) for patch in patches])
    return Scatter(tuple(patches), excess, excess_sigma, renewal, renewal_sigma, place)


def variance(patch: Patch, spread: NDArray[np.floating]) -> Vector:
    """(n,) mean square in native units of a spread (h, w) [m], over the pixels that have one and a measured one."""
    squares, share = patch.told
    return patch.tiles.mean(np.square(spread) * squares) / share


def predicted_variance(patch: Patch, spread: NDArray[np.floating]) -> Vector:
    """(n,) variance in native units by a predicted spread (h, w) [m], no smaller than frames can show."""
    return np.maximum(variance(patch, spread) + stored_step(patch) ** 2 / 12, _least(patch))


def _least(patch: Patch) -> float:
    """Where all frames round to one step nobody knows how near the next one is: neither the model nor they."""
    return max(float(np.exp(-WANDERS)) * patch.step**2 / 12, LEAST_VARIANCE)


def _scatter(patch: Patch) -> tuple[Vector, Vector, Vector, Vector]:
    n, block = len(patch.block.frames), patch.block
    measured = np.maximum(variance(patch, block.std), _least(patch))
    pixels = patch.tiles.pixels / _sharing(patch)
    floor = FLOOR**2 + _undithered(patch) ** 2
    whole, renewed = filtered(patch, _memory(patch))
    excess = np.log(measured) - whole
    excess_sigma = np.sqrt(2.0 / ((n - 1) * pixels) + floor)
    if n < 3 or block.succession is None:
        return excess, excess_sigma, np.zeros(len(excess)), np.full(len(excess), np.inf)
    new = variance(patch, np.sqrt(block.succession))
    renewal = np.log(np.maximum(new, _least(patch)) / measured) - renewed
    # von Neumann's ratio of normal noise, of which each pixel weighs with its own variance
    ratio = (n - 2) / ((n + 1) * (n - 1)) * (1 + 2 / (n - 1))
    return excess, excess_sigma, renewal, np.sqrt(ratio / pixels + floor)


def filtered(patch: Patch, memory: float) -> tuple[Vector, Vector]:
    """Logarithms (n,) of the variance in native units that these frames show where each keeps a share `memory` of the
    one before, and of the share of it that is new in each: what the file rounds always is.
    """
    own = _memory(patch)  # of a long series, which is what the model predicts
    unmixed = variance(patch, patch.sigma) * (1 + own) / (1 - own)
    whole, renewed = succession_of(round(memory, 6), len(patch.block.frames), started=patch.block.frames[0] == 0)
    stored = stored_step(patch) ** 2 / 12
    # of a model without noise both are the least that frames can show: all of it is new
    total, new = (np.maximum(unmixed * np.exp(part) + stored, _least(patch)) for part in (whole, whole + renewed))
    return np.log(total), np.log(new / total)


def _memory(patch: Patch) -> float:
    return max((memory_of(effect) for effect in patch.sensor.effects), default=0.0)


def _sharing(patch: Patch) -> float:
    """Pixels that share their noise, in effect: the sum of the squared correlations over all neighbours."""
    alike = patch.alike
    if alike is None:
        return 1.0
    return float(np.prod(1 + 2 * (np.square(alike[:, 1:])).sum(axis=1)))


def _undithered(patch: Patch) -> float:
    """How far a variance may wander (share of it) with the place between two steps of the rounding."""
    step = max(patch.step, stored_step(patch))
    # as the frames show: a model that has too little noise earns no allowance by it
    before = np.sqrt(max(float(variance(patch, patch.block.std).mean()) - step**2 / 12, 0.0))
    # the first harmonic of the rounding's own error, which fades as the noise grows over a step
    return WANDERS * float(np.exp(-2 * np.pi**2 * (before / step) ** 2)) if step > 0 else 0.0


def stored_step(patch: Patch) -> float:
    """A count of the file in native units, less what the model itself rounds; 0 where nobody knows."""
    recording = getattr(patch.block.stage, "recording", None)
    if recording is None or not len(patch.tiles):
        return 0.0
    count = patch.usual_native / recording.camera.depth_scale
    return float(np.sqrt(max(count**2 - patch.step**2, 0.0)))


def frozen_rounding(patch: Patch) -> float:
    """Mean square in native units that rounding, the model's or the file's, may leave in the mean of many frames.

    Where on its steps a pixel is nobody knows: the model's rounding and the frames' differ as two that share nothing.
    """
    step, times = max((patch.step, 2), (stored_step(patch), 1))
    if not step:
        return 0.0
    before = max(float(np.median(variance(patch, patch.block.std))) - step**2 / 12, 0.0)
    return times * step**2 / 12 * float(np.exp(-4 * np.pi**2 * before / step**2))
