"""The first guess: in which direction the axis points, and by how much the table turned between frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.pairs.edges import Edges, ViewStack
from fusion.turntable.pairs.misfit import misfits

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FoundTurns:
    """The turns of m pairs of views."""

    turns: Array  # (m,) [rad], right-handed about the axis
    misfit: Array  # (m,) 0 (perfect) to 1


def axis_guesses(centre: Array) -> list[Axis]:
    """Axes through the middle (3,) of what moves [m], upright for a camera tilted down by 0 to 80 degrees."""
    tilts = np.deg2rad([0, 20, 40, 60, 80])
    return [Axis(centre, pose.exp([tilt, 0, 0, 0, 0, 0])[:3, :3] @ np.array([0, -1.0, 0])) for tilt in tilts]


def find_turns(seen: ViewStack, edges: Edges, axis: Axis, candidates: Array, reach: float) -> FoundTurns:
    """The turns that fit m pairs of views best: a search over candidates (m, k) [rad], then ever finer."""

    def best_of(turns: Array) -> FoundTurns:
        k = turns.shape[1]
        tried = [edge for edge in edges for _ in range(k)]
        values = misfits(seen, tried, Turns(axis, turns.ravel()), reach).reshape(turns.shape)
        best = np.argmin(values, axis=1)[:, None]
        return FoundTurns(np.take_along_axis(turns, best, 1)[:, 0], np.take_along_axis(values, best, 1)[:, 0])

    found = best_of(candidates)
    spacing = float(np.min(np.diff(candidates, axis=1))) if candidates.shape[1] > 1 else np.deg2rad(2.0)
    for _ in range(3):
        spacing /= 2
        found = best_of(found.turns[:, None] + spacing * np.array([-1.0, 0.0, 1.0]))
    return found


def search_range(largest: float = np.deg2rad(25), spacing: float = np.deg2rad(2.5)) -> Array:
    """Candidate steps [rad] from -largest to largest."""
    n = int(np.ceil(largest / spacing))
    return np.asarray(np.arange(-n, n + 1) * spacing, float)


def axis_through(direction: Array, points: Array) -> Axis:
    """The axis along a direction (3,) through the middle of what points (n, 3) of all views fill: half of it shows, so
    that it reaches as far behind its nearest as it does to the sides."""
    middle = np.median(points, axis=0)
    sideways = np.cross(direction, middle)
    sideways /= np.linalg.norm(sideways)
    away = np.cross(sideways, direction)
    away *= np.sign(away @ middle)
    left, right = np.percentile(points @ sideways, [1, 99])
    near, far = np.percentile(points @ away, [1, 99])
    depth = min(near + (right - left) / 2, max(far, near + 0.005))
    along = np.percentile(points @ direction, [1, 99]).mean()
    return Axis((left + right) / 2 * sideways + depth * away + along * direction, direction)
