"""Rounding: where its steps lie while it is not known exactly what is rounded."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference import covariance
from fusion.discrepancy.inference.own_pattern import unknown_patterns
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.recording.ahead import side_by_side
from fusion.sensor.effect import Effect
from fusion.sensor.view import Image

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Phasors = NDArray[np.complex128]

SAME = 16  # power of a correlation of patterns: only squares that see the very same jumps share what these break
HARMONICS = 12  # of a saw-tooth: what the others leave out is a hundredth of a step
FAINT = 1e-3  # of a step: harmonics that noise has faded so far are none
ORDERS = 40  # of a correlation: what tiles share beyond is next to nothing, and counts as each one's own
DOUBT = 0.25  # share of the noise before a rounding to which it is known, of which the steps hide most (guess)
NOTHING = 1e-8  # of a step, or of the size of an error: what it adds to a covariance is the square of it


def rounding_covariance(
    observations: Observations, before: Matrix, patterns: Matrix, law: float = 0.0, doubt: float = 0.0
) -> Matrix:
    """(n, n) what rounding adds, in native units, to the covariance of errors that happen before it.

    A mean over frames of noise sigma is x + sum over k of Im p, p = (-1)^k exp(2 pi i k x - 2 (pi k sigma)^2) / (pi k),
    x in steps. Where x is off by a normal e, amid a step nothing of e is seen, at its edge far more than e.

    Args:
        before: (n, n) covariance of e in native units: speckle, poses, patterns, known parameters.
        patterns: (n, n) part of it that jumps between pixels.
        law: by how much a law that nobody knows yet moves what is rounded, in native units. What is linear in it is no
            error; what is not, tiles of a recording share.
        doubt: share of the noise before the rounding to which it is known.
    """
    total = np.zeros_like(before)
    parts = side_by_side(_waves, observations.patches)
    turns, waves, spread, broken = (np.concatenate(own) for own in zip(*parts, strict=True))
    if not np.any(waves):
        return total
    # each harmonic fades with the square of the noise that is not known exactly: in all recordings alike
    fades = (2 * np.pi * np.arange(1, HARMONICS + 1) * spread[:, None]) ** 2
    faded = doubt * (fades * waves.imag).sum(axis=1)
    total += np.outer(faded, faded)
    for rows, patch in observations.rows():
        for effect in patch.sensor.effects:
            if effect.frozen == "scene" and patch.unrounded is not None:
                total[rows, rows] += _speckled(patch, effect)
    place = observations.place
    together = place[:, None] == place
    if np.any(broken):
        usual = np.sqrt(np.maximum(np.diag(patterns), 1e-300))
        same = (patterns / np.outer(usual, usual)) ** SAME * together
        total += np.sqrt(np.outer(broken, broken)) * same
    return total + _added(waves, turns, before, law**2 * together)


def _added(waves: Phasors, turns: Vector, before: Matrix, law: Matrix) -> Matrix:
    """(n, n) mean products of x + e + Im p(x + e) less the same without e, for normal e, less those of e: Mehler.

    Args:
        waves: (n, k) harmonics p.
        turns: (n,) [rad] that the first of them turns per unit of e.
        before: (n, n) covariance of e.
        law: (n, n) covariance of more of it, of which what is linear is left out.
    """
    usual = np.sqrt(np.maximum(np.diag(before) + np.diag(law), 1e-300))
    rate = turns[:, None] * np.arange(1, waves.shape[1] + 1) * usual[:, None]
    kept = waves * np.exp(-0.5 * rate**2)
    left, term = (kept - waves).imag.sum(axis=1), 1j * rate * kept
    slope = 1.0 + term.imag.sum(axis=1) / usual
    rest, orders = _variance(waves, rate) - (slope * usual - usual) ** 2 - kept.imag.sum(axis=1) ** 2, []
    for n in range(2, ORDERS + 1):
        term = term * 1j * rate / np.sqrt(n)
        orders.append(term.imag.sum(axis=1))
        rest -= orders[-1] ** 2
    total = before * (np.outer(slope, slope) - 1.0)
    stepped = np.flatnonzero(np.any(waves, axis=1))
    some = np.ix_(stepped, stepped)
    alike = (before[some] + law[some]) / np.outer(usual[stepped], usual[stepped])
    power, told = alike, np.outer(left[stepped], left[stepped])
    last = max((k for k, own in enumerate(orders) if np.any(np.abs(own) > NOTHING * usual)), default=-1)
    for own in orders[: last + 1]:
        power = power * alike
        told += own[stepped, None] * power * own[stepped]
    told[np.diag_indices(len(told))] += np.maximum(rest[stepped], 0.0)
    total[some] += told
    return np.asarray(total)


def _variance(waves: Phasors, rate: Matrix) -> Vector:
    """(n,) mean square of Im p(x + e)."""
    out = np.zeros(len(waves))
    for k, one in enumerate(waves.T):
        for m, other in enumerate(waves.T):
            apart, along = (np.exp(-0.5 * (rate[:, k] + sign * rate[:, m]) ** 2) for sign in (-1, 1))
            out += 0.5 * ((one * other.conj()).real * apart - (one * other).real * along)
    return out


def _speckled(patch: Patch, speckle: Effect) -> Matrix:
    """(n, n) covariance of squares in which speckle moves pixels to other steps.

    Each harmonic has a window of its own, as phases part sooner than what turns them.
    """
    tiles, unrounded = patch.tiles, patch.unrounded
    assert unrounded is not None
    with np.errstate(all="ignore"):
        moved = speckle.noise(unrounded.mean, patch.view) / unrounded.step
        turned = float(np.nanmedian(np.where(tiles.label >= 0, moved, np.nan)))
        total, usual = np.zeros((len(tiles), len(tiles))), np.max(tiles.mean(unrounded.step * np.abs(patch.native)))
        for k in range(1, HARMONICS + 1) if turned else ():
            phase = (2 * np.pi * k * turned) ** 2
            # about the mean that is predicted, which is that of all speckle
            size = np.sqrt(tiles.mean(_height(patch, unrounded.spread, k) ** 2) * -0.5 * np.expm1(-phase))
            if np.max(size) < NOTHING * usual:
                break
            window = speckle.window(patch.view) * 2 * (1 / phase - 1 / np.expm1(phase))
            total += np.outer(size, size) * covariance.grain(tiles.cell, tiles.cell, tiles.side, window)
    return total


def _height(patch: Patch, spread: Image, k: int) -> Image:
    """(h, w) |p| of a harmonic in native units, where values differ by `spread` (h, w) steps before the rounding."""
    assert patch.unrounded is not None
    faded = np.exp(-2 * (np.pi * k * spread) ** 2) / (np.pi * k)
    return np.asarray(patch.unrounded.step * np.abs(patch.native) * faded)


def _waves(patch: Patch) -> tuple[Vector, Phasors, Vector, Vector]:
    """Of each tile (n,): [rad] that its first harmonic turns per native unit, its means of p (n, k), what smooths them
    [steps], and what jumps add.

    Waves of a slope cancel within a square, but for a part of one where the pattern of the unit jumps in it.
    """
    unrounded, n = patch.unrounded, len(patch.tiles)
    if unrounded is None:
        return np.ones(n), np.zeros((n, HARMONICS), complex), np.zeros(n), np.zeros(n)
    with np.errstate(all="ignore"):
        waves, broken, jumps = np.zeros((n, HARMONICS), complex), np.zeros(n), any(unknown_patterns(patch.sensor))
        phase = unrounded.mean / unrounded.step
        slope = np.hypot(*np.gradient(phase)) * patch.tiles.side  # steps over a square
        turned, whole = -np.exp(2j * np.pi * phase), np.ones_like(phase, complex)
        step = patch.tiles.mean(unrounded.step * np.abs(patch.native))
        for k in range(1, HARMONICS + 1):
            height, whole = _height(patch, unrounded.smoothed, k), whole * turned
            if np.max(patch.tiles.mean(height) / step) < FAINT:
                break
            waves[:, k - 1] = patch.tiles.mean(height * whole.real) + 1j * patch.tiles.mean(height * whole.imag)
            if jumps:
                part = np.minimum(1.0 / (2 * np.pi * k * slope), 0.5)
                broken += patch.tiles.mean((height * part) ** 2)
        spread = patch.tiles.mean(unrounded.smoothed)
    return 2 * np.pi / step, waves, spread, broken
