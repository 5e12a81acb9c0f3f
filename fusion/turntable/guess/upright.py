"""The axis to begin with: upright on what the object stands on, or leaning like a guess."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.loop import LoopSettings, close_loop
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.agreeing import NEIGHBOURS
from fusion.turntable.guess.everywhere import listen
from fusion.turntable.guess.start import axis_guesses, axis_through
from fusion.turntable.pairs.edges import ViewStack, stack
from fusion.turntable.table.foot import foot_normal
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]

SOME = 4  # views that show what is behind them all
PROBED = 8  # neighbours that tell the axis


def upright_axis(
    views: Sequence[ObjectView], seen: ViewStack, region: Region, keys: NDArray[np.intp], foot: Array | None = None
) -> Axis:
    """The axis that brings neighbours together best: upright on what the object stands on, or leaning like a guess."""
    points = np.concatenate([v.points[:: max(1, len(v.points) // 3000)] for v in views]).astype(float)
    if foot is None and region.wall is not None and region.wall.shape == views[0].map.camera.shape:
        foot = foot_normal(_seen_behind(views, region.wall), points)
    guesses = [axis_through(g.direction, points) for g in axis_guesses(np.median(points, axis=0))]
    tried = guesses if foot is None else [axis_through(foot, points)]
    some = np.unique(np.linspace(0, len(keys) - 2, min(PROBED, len(keys) - 1)).astype(int))
    pairs = [(int(keys[k]), int(keys[k + 1])) for k in some]

    def fit(axis: Axis) -> tuple[float, Axis]:
        heard = listen(seen, axis, pairs, NEIGHBOURS)
        worth = heard.worth(heard.printed() / 2)
        best: dict[tuple[int, int], tuple[float, int]] = {}
        for k, (edge, w) in enumerate(zip(heard.edges, worth, strict=True)):
            best[edge] = max(best.get(edge, (-1.0, k)), (float(w), k))
        if not best:
            return 0.0, axis
        value = sum(w for w, _ in best.values()) / len(pairs)
        if foot is not None or value < 0.1:
            return value, axis
        both = stack([seen_view(seen, k) for pair in best for k in pair])
        angles = np.zeros(2 * len(best))
        angles[1::2] = [heard.found.turns[k] for _, k in best.values()]
        alone = [(k, k + 1) for k in range(0, len(angles), 2)]
        closed = close_loop(both, Turns(axis, angles), alone, LoopSettings((0.03, 0.015), (5, 4)))
        return value, axis_through(closed.axis.direction, points) if closed.axis.direction[1] < 0 else axis

    value, axis = max((fit(axis) for axis in tried), key=lambda found: found[0])
    if foot is not None and value < 0.15:  # it stands on something else
        foot = None
        value, axis = max((fit(axis) for axis in guesses), key=lambda found: found[0])
    return axis


def _seen_behind(views: Sequence[ObjectView], wall: NDArray[np.float32]) -> Array:
    """Points (n, 3) of some views that lie behind the object: seen there, not filled in where it hides all."""
    some = (v.map.points.reshape(-1, 3) for v in views[:: max(1, len(views) // SOME)])
    return np.concatenate([points[points[:, 2] >= wall.ravel()] for points in some]).astype(float)


def seen_view(seen: ViewStack, k: int) -> ObjectView:
    """A view with the points that its stack has of it."""
    part = slice(int(seen.first[k]), int(seen.first[k + 1]))
    points = seen.points[part]
    return ObjectView(seen.views[k].map, points[:, :3], points[:, 3:6], points[:, 6])
