"""How two views of the ground lie to each other: the turns and shifts that bring the marks of one onto the other's."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrc

from fusion.turntable.below.ground import Ground
from fusion.turntable.below.marks import FEWEST, Marks

Array = NDArray[np.float64]
ALIKE = 16  # marks of the other view that a mark may be
LESS = 0.75  # of the likeness of the likeliest
TURNS = 180  # of the circle that are tried
SHIFTS = 51  # each way
KEPT = 3  # places that are looked at closer
NEAR = 3.0  # [px] of a view from above: as the same mark
SURE = 6.0  # decimals of the chance that says enough (guess)


@dataclass(frozen=True)
class Meeting:
    """A motion of the ground in its plane between two views."""

    turn: float  # [rad], right-handed about the upright
    shift: Array  # (2,) after the turn, which is about the middle of the square [m]
    sure: float  # 0 to 1: how small the chance is that so many marks meet in no motion of the ground


def meetings(first: Marks, second: Marks, ground: Ground) -> list[Meeting]:
    """What may bring the first view onto the second, the surest first: Hough's votes of the pairs that look alike."""
    if min(len(first.at), len(second.at)) < FEWEST:
        return []
    a, b, cell = first.at, second.at, 2 * ground.half / (SHIFTS - 1)
    i, j = _alike(first, second)
    angles = np.arange(TURNS) * 2 * np.pi / TURNS
    moved = _turned(a[i], angles)
    bins = np.rint((b[j] - moved) / cell).astype(int) + SHIFTS // 2
    inside = ((bins >= 0) & (bins < SHIFTS)).all(axis=-1)
    index = (np.arange(TURNS)[:, None] * SHIFTS + bins[..., 1]) * SHIFTS + bins[..., 0]
    votes = np.bincount(index[inside], minlength=TURNS * SHIFTS**2).reshape(TURNS, SHIFTS, SHIFTS).astype(np.float32)
    votes = np.stack([cv2.boxFilter(layer, -1, (3, 3), normalize=False) for layer in votes])
    found = []
    for _ in range(KEPT):
        at, row, column = np.unravel_index(int(np.argmax(votes)), votes.shape)
        shift = (np.array([column, row]) - SHIFTS // 2) * cell
        met = _closer(first, second, ground, Meeting(float(angles[at]), shift, 0.0), cell)
        if met is not None:
            found.append(met)
        votes[np.arange(at - 4, at + 5) % TURNS] = -1
    return sorted(found, key=lambda m: -m.sure)


def _alike(first: Marks, second: Marks) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of marks that may be the same: dots are all alike, a grain has one that fits."""
    likeness = np.einsum("aok,bqk->abqo", first.looks, second.looks, optimize=True).max(axis=(2, 3))
    likeness[first.bright[:, None] != second.bright] = -1
    rank = np.argsort(np.argsort(-likeness, axis=1), axis=1)
    best = likeness.max(axis=1, keepdims=True)
    i, j = np.nonzero((rank < ALIKE) & (likeness > LESS * best) & (likeness > 0))
    return i, j


def _turned(points: Array, angles: Array) -> Array:
    """(k, n, 2) points (n, 2) after turns (k,)."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = points.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _closer(first: Marks, second: Marks, ground: Ground, start: Meeting, cell: float) -> Meeting | None:
    """The motion with which most marks meet near one that was found, and how sure that is; None where few do."""
    turn, shift, near = start.turn, start.shift, NEAR * ground.pitch
    for reach in (2 * cell, cell, near, near, near):
        moved = _turned(first.at, np.array([turn]))[0] + shift
        apart = np.linalg.norm(moved[:, None] - second.at, axis=-1)
        apart[first.bright[:, None] != second.bright] = np.inf
        partner = apart.argmin(axis=1)
        own = np.arange(len(moved))
        meet = (apart[own, partner] < max(reach, near)) & (apart.argmin(axis=0)[partner] == own)
        if meet.sum() < FEWEST:
            return None
        p, q = first.at[meet], second.at[partner[meet]]
        (px, py), (qx, qy) = (p - p.mean(axis=0)).T, (q - q.mean(axis=0)).T
        turn = float(np.arctan2((px * qy - py * qx).sum(), (px * qx + py * qy).sum()))
        shift = q.mean(axis=0) - _turned(p.mean(axis=0)[None], np.array([turn]))[0, 0]
    pixels = np.floor((moved + ground.half) / ground.pitch).astype(int)
    inside = ((pixels >= 0) & (pixels < len(second.shown))).all(axis=1)
    visible = int(second.shown[pixels[inside, 1], pixels[inside, 0]].sum())
    area = max(float(second.shown.sum()), 1.0)
    chance = 1 - np.exp(-len(second.at) * np.pi * NEAR**2 / area)
    tried = np.log10(TURNS * (2 * ground.half / near) ** 2)
    by_chance = float(bdtrc(meet.sum() - 1, max(visible, meet.sum()), chance))  # that as many meet, or more
    decimals = -np.log10(max(by_chance, 1e-300)) - tried
    return Meeting(turn, shift, float(np.clip(decimals / SURE, 0, 1)))
