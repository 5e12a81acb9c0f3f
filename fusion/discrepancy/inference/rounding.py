"""Rounding: where its steps lie while it is not known exactly what is rounded; noise that is small beside a step does
not hide them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.own_pattern import unknown_patterns
from fusion.discrepancy.observe.observations import Observations, Patch, predicted
from fusion.sensor.effect import Effect

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Phasors = NDArray[np.complex128]

STEP = 12**0.5  # over the spread of what rounding to it loses
HIDDEN = 0.46  # of a step: noise that leaves a two-hundredth of it, which is a tenth of that noise in a square's mean
SAME = 16  # power of a correlation of patterns: only squares that see the very same jumps share what these break
HARMONICS = 3  # of what rounding leaves of a mean: the fourth is a quarter of the first, and any noise hides it


def rounding_covariance(observations: Observations, before: Matrix, patterns: Matrix) -> Matrix:
    """(n, n) mean products, in native units, of what rounding adds to tiles that are off by what is not known.

    A mean over frames of noise sigma is off by the sum over k of Im p, p = exp(2 pi i k x - 2 (pi k sigma)^2) / (pi k),
    x in steps. Where x is off by a normal e, p is p exp(2 pi i k e) and no more what was predicted.

    Args:
        before: (n, n) covariance of e in native units: poses, patterns, known parameters.
        patterns: (n, n) part of it that jumps between pixels.
    """
    total = np.zeros_like(before)
    rounding = next((effect for effect in observations.sensor.effects if effect.lattice), None)
    if rounding is None:
        return total
    shown = [_shows(patch, rounding) for patch in observations.patches]
    if not any(shown):
        return total
    parts = [_phasors(p, rounding) if s else _none(p) for p, s in zip(observations.patches, shown, strict=True)]
    steps, heights, broken = (np.concatenate(own) for own in zip(*parts, strict=True))
    some = np.flatnonzero(heights[:, 0])
    place, at = observations.place[some], np.ix_(some, some)
    one = patterns[at] / np.maximum(np.sqrt(np.outer(np.diag(patterns)[some], np.diag(patterns)[some])), 1e-300)
    total[at] = np.sqrt(np.outer(broken[some], broken[some])) * one**SAME * (place[:, None] == place)
    turns = before[at] / np.outer(steps[some], steps[some])
    for k in range(1, HARMONICS + 1):
        total[at] += _products(heights[some, k - 1], (2 * np.pi * k) ** 2 * turns)
    return total


def _products(p: Phasors, phase: Matrix) -> Matrix:
    """(m, m) mean products of Im p exp(i e) - Im p for normal e of a covariance (m, m) [rad^2]."""
    alone = np.diag(phase)
    apart, along = (0.5 * (alone[:, None] + alone) + sign * phase for sign in (-1.0, 1.0))
    mean = np.outer(p, p.conj()).real * np.exp(-apart) - np.outer(p, p).real * np.exp(-along)
    cross = np.outer(p.imag * np.exp(-0.5 * alone), p.imag)
    return np.asarray(0.5 * mean - cross - cross.T + np.outer(p.imag, p.imag))


def _shows(patch: Patch, rounding: Effect) -> bool:
    """True where the noise of the frames, the model's or the measured, is small enough not to hide the steps."""
    with np.errstate(all="ignore"):
        spread = np.fmin(patch.sigma, patch.block.std) / (STEP * rounding.noise(patch.predicted, patch.view))
    return bool(len(patch.tiles) and np.nanmedian(spread) < HIDDEN)


def _none(patch: Patch) -> tuple[Vector, Phasors, Vector]:
    n = len(patch.tiles)
    return np.ones(n), np.zeros((n, HARMONICS), complex), np.zeros(n)


def _phasors(patch: Patch, rounding: Effect) -> tuple[Vector, Phasors, Vector]:
    """(n,) step of each tile and (n, k) means of p over it, in native units; and (n,) what jumps of a pattern add.

    Waves of a slope cancel within a square, but for a part of one where the pattern of the unit jumps in it.
    """
    others = tuple(effect for effect in patch.sensor.effects if effect is not rounding)
    mean, sigma = predicted(replace(patch.sensor, effects=others), patch.block)
    with np.errstate(all="ignore"):
        step = STEP * rounding.noise(mean, patch.view)  # [m] at this depth: constant, or growing with its square
        calm = np.sqrt(np.maximum(patch.block.std**2 - step**2 / 12, 0.0))
        spread, native = np.fmin(sigma, calm) / step, step * np.abs(patch.native)
        waves, broken, jumps = [], np.zeros(len(patch.tiles)), any(unknown_patterns(patch.sensor))
        slope = np.hypot(*np.gradient(mean / step)) * patch.tiles.side  # steps over a square
        for k in range(1, HARMONICS + 1):
            p = native * np.exp(2j * np.pi * k * mean / step - 2 * (np.pi * k * spread) ** 2) / (np.pi * k)
            waves.append(patch.tiles.mean(p.real) + 1j * patch.tiles.mean(p.imag))
            part = np.minimum(1.0 / (2 * np.pi * k * slope), 0.5)
            broken += jumps * patch.tiles.mean((np.abs(p) * part) ** 2)
    return patch.tiles.mean(native), np.column_stack(waves), broken
