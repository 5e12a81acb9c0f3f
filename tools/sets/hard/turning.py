"""How a table or a hand turns a thing: angles frame by frame, where the axis drifts, when a hand is seen."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator

MOST = 60.0  # [deg] largest step of a hand


@dataclass(frozen=True)
class Turning:
    """Attributes:
    degrees: (n,) right-handed about the axis that points up, 0 at first.
    logged: (n,) [deg] or None.
    shift: (n, 2) [m] of the axis over the table.
    by_hand: a hand turns it.
    hand: (n,) whether the hand is in the picture.
    """

    degrees: Array
    logged: Array | None
    shift: Array
    by_hand: bool
    hand: NDArray[np.bool_]

    @property
    def poses(self) -> Array:
        """(n, 4, 4) of the plate in the world."""
        out = np.array([trimesh.transformations.rotation_matrix(np.deg2rad(a), [0, 0, 1]) for a in self.degrees])
        out[:, :2, 3] = self.shift
        return out


def whole(rng: Rng) -> float:
    """[deg] in all: a part of a turn, about one, or several."""
    kind = rng.choice(["part", "one", "more", "several"], p=[0.25, 0.45, 0.15, 0.15])
    low, high = {"part": (120, 300), "one": (355, 400), "more": (400, 700), "several": (720, 1100)}[str(kind)]
    return float(rng.uniform(low, high))


def motor(rng: Rng, degrees: float) -> Turning:
    """Even steps, a log in two of three; no more than 60 frames."""
    count = int(np.clip(degrees / rng.uniform(5, 14), 18, 60))
    even = np.linspace(0, degrees, count)
    way = rng.choice([-1, 1])
    true = way * (even + 0.05 * rng.standard_normal(count))
    logged = way * even if rng.random() < 2 / 3 else None
    return Turning(true - true[0], logged, np.zeros((count, 2)), False, np.zeros(count, bool))


def by_hand(rng: Rng, degrees: float, loose: bool) -> Turning:
    """Uneven steps up to 60 deg, stops, a drifting axis (more where it is `loose`: no plate below), no log."""
    middle = float(rng.choice([9.0, 14.0, 22.0, 34.0], p=[0.3, 0.3, 0.25, 0.15]))
    middle = max(middle, degrees / 55)
    steps: list[float] = []
    while sum(steps) < degrees:
        steps.append(float(np.clip(middle * np.exp(0.35 * rng.standard_normal()), 1.5, MOST)))
    if rng.random() < 0.4:
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(0, len(steps)))
            steps[at:at] = list(np.abs(0.15 * rng.standard_normal(int(rng.integers(2, 5)))))
    true = np.concatenate([[0.0], np.cumsum(steps)]) * rng.choice([-1, 1])
    count = len(true)
    shift = np.zeros((count, 2))
    if loose or rng.random() < 0.4:
        far = rng.uniform(0.002, 0.008 if loose else 0.003)
        t = np.linspace(0, 1, count)[:, None]
        wave = np.sin(2 * np.pi * (t * rng.uniform(0.3, 1.2, 2) + rng.random(2)))
        wave = wave - wave[0]
        shift = far * wave / np.linalg.norm(wave, axis=1).max()
    hand = np.zeros(count, bool)
    if rng.random() < 0.5:
        hand = rng.random(count) < rng.uniform(0.15, 0.5)
    return Turning(true, None, shift, True, hand)


def still(count: int) -> Turning:
    """Nothing turns."""
    return Turning(np.zeros(count), None, np.zeros((count, 2)), False, np.zeros(count, bool))
