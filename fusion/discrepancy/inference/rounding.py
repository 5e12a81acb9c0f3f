"""Rounding: where its steps lie while it is not known exactly what is rounded."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference import covariance
from fusion.discrepancy.inference.own_pattern import unknown_patterns
from fusion.discrepancy.observe.observations import Observations, Patch
from fusion.sensor.effect import Effect
from fusion.sensor.view import Image

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Phasors = NDArray[np.complex128]

SAME = 16  # power of a correlation of patterns: only squares that see the very same jumps share what these break
MANY = 12  # of them, where pixels jump: what the others leave out is a hundredth of a step
HARMONICS = 3  # of what rounding leaves of a mean: the fourth is a quarter of the first, and any noise hides it


def rounding_covariance(observations: Observations, before: Matrix, patterns: Matrix) -> Matrix:
    """(n, n) mean products, in native units, of what rounding adds to tiles that are off by what is not known.

    A mean over frames of noise sigma is off by the sum over k of Im p, p = exp(2 pi i k x - 2 (pi k sigma)^2) / (pi k),
    x in steps. Where x is off by a normal e, p is p exp(2 pi i k e) and no more what was predicted.

    Args:
        before: (n, n) covariance of e in native units: poses, patterns, known parameters, laws that nobody knows.
        patterns: (n, n) part of it that jumps between pixels.
    """
    total = np.zeros_like(before)
    parts = [_phasors(patch) for patch in observations.patches]
    steps, heights, broken = (np.concatenate(own) for own in zip(*parts, strict=True))
    if not np.any(heights):
        return total
    for rows, patch in observations.rows():
        for effect in patch.sensor.effects:
            if effect.frozen == "scene" and patch.unrounded is not None:
                total[rows, rows] += _speckled(patch, effect)
    some = np.flatnonzero(heights[:, 0])
    place, at = observations.place[some], np.ix_(some, some)
    if np.any(broken):
        usual = np.sqrt(np.maximum(np.diag(patterns)[some], 1e-300))
        same = (patterns[at] / np.outer(usual, usual)) ** SAME * (place[:, None] == place)
        total[at] += np.sqrt(np.outer(broken[some], broken[some])) * same
    turns = before[at] / np.outer(steps[some], steps[some])
    for k in range(1, HARMONICS + 1):
        total[at] += _products(heights[some, k - 1], (2 * np.pi * k) ** 2 * turns)
    return total


def _products(p: Phasors, phase: Matrix) -> Matrix:
    """(m, m) mean products of Im p exp(i e) - Im p for normal e of a covariance (m, m) [rad^2]."""
    alone = 0.5 * np.diag(phase)
    both, kept = alone[:, None] + alone, np.exp(-alone)
    apart, along = np.exp(phase - both), np.exp(-phase - both)
    mean = np.outer(p.real, p.real) * (apart - along) + np.outer(p.imag, p.imag) * (apart + along)
    left, stays = p.imag * (1.0 - kept), p.imag * kept
    return np.asarray(0.5 * mean + np.outer(left, left) - np.outer(stays, stays))


def _speckled(patch: Patch, speckle: Effect) -> Matrix:
    """(n, n) covariance of squares in which speckle moves pixels to other steps.

    Each harmonic has a window of its own, as phases part sooner than what turns them.
    """
    tiles, unrounded = patch.tiles, patch.unrounded
    assert unrounded is not None
    with np.errstate(all="ignore"):
        moved = speckle.noise(unrounded.mean, patch.view) / unrounded.step
        turned = float(np.nanmedian(np.where(tiles.label >= 0, moved, np.nan)))
        total = np.zeros((len(tiles), len(tiles)))
        for k in range(1, MANY + 1) if turned else ():
            phase = (2 * np.pi * k * turned) ** 2
            # about the mean that is predicted, which is that of all speckle
            size = np.sqrt(tiles.mean(_height(patch, unrounded.spread, k) ** 2) * -0.5 * np.expm1(-phase))
            window = speckle.window(patch.view) * 2 * (1 / phase - 1 / np.expm1(phase))
            total += np.outer(size, size) * covariance.grain(tiles.cell, tiles.cell, tiles.side, window)
    return total


def _height(patch: Patch, spread: Image, k: int) -> Image:
    """(h, w) |p| of a harmonic in native units, where values differ by `spread` (h, w) steps before the rounding."""
    assert patch.unrounded is not None
    faded = np.exp(-2 * (np.pi * k * spread) ** 2) / (np.pi * k)
    return np.asarray(patch.unrounded.step * np.abs(patch.native) * faded)


def _phasors(patch: Patch) -> tuple[Vector, Phasors, Vector]:
    """(n,) step of each tile and (n, k) means of p over it, in native units; and (n,) what jumps of a pattern add.

    Waves of a slope cancel within a square, but for a part of one where the pattern of the unit jumps in it.
    """
    unrounded, n = patch.unrounded, len(patch.tiles)
    if unrounded is None:
        return np.ones(n), np.zeros((n, HARMONICS), complex), np.zeros(n)
    with np.errstate(all="ignore"):
        waves, broken, jumps = [], np.zeros(n), any(unknown_patterns(patch.sensor))
        turns = unrounded.mean / unrounded.step
        slope = np.hypot(*np.gradient(turns)) * patch.tiles.side  # steps over a square
        for k in range(1, HARMONICS + 1):
            height = _height(patch, unrounded.smoothed, k)
            p = height * np.exp(2j * np.pi * k * turns)
            waves.append(patch.tiles.mean(p.real) + 1j * patch.tiles.mean(p.imag))
            part = np.minimum(1.0 / (2 * np.pi * k * slope), 0.5)
            broken += jumps * patch.tiles.mean((height * part) ** 2)
    return patch.tiles.mean(unrounded.step * np.abs(patch.native)), np.column_stack(waves), broken
