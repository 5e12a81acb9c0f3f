"""The first guess: in which direction the axis points, and by how much the table turned between frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.axis import Axis
from fusion.turntable.views import View, misfit

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Step:
    """The turn between two frames.

    Attributes:
        angle: [rad], right-handed about the axis.
        misfit: 0 (perfect) to 1.
    """

    angle: float
    misfit: float


def axis_guesses(centre: Array) -> list[Axis]:
    """Axes through the middle (3,) of what moves [m], upright for a camera tilted down by 0 to 80 degrees."""
    tilts = np.deg2rad([0, 20, 40, 60, 80])
    return [Axis(centre, pose.exp([tilt, 0, 0, 0, 0, 0])[:3, :3] @ np.array([0, -1.0, 0])) for tilt in tilts]


def find_step(source: View, model: View, axis: Axis, candidates: Array, reach: float) -> Step:
    """The turn that fits two views best: a search over candidate angles [rad], then ever finer."""
    values = np.array([misfit(source, model, axis, float(a), reach) for a in candidates])
    best = float(candidates[np.argmin(values)])
    spacing = float(np.min(np.diff(candidates))) if len(candidates) > 1 else np.deg2rad(2.0)
    for _ in range(3):
        spacing /= 2
        near = best + spacing * np.array([-1.0, 0.0, 1.0])
        values = np.array([misfit(source, model, axis, float(a), reach) for a in near])
        best = float(near[np.argmin(values)])
    return Step(best, float(np.min(values)))


def search_range(largest: float = np.deg2rad(25), spacing: float = np.deg2rad(2.5)) -> Array:
    """Candidate steps [rad] from -largest to largest."""
    n = int(np.ceil(largest / spacing))
    return np.asarray(np.arange(-n, n + 1) * spacing, float)
