"""The motion when nothing is told: all pairs of views are compared at all turns, and one motion agrees with most.

Neighbours need not be near: a hand turns by 10 degrees or by 60, stops, or goes back, and the first view that comes
again closes the loop by itself. A hand also moves the object; where one axis fits clearly worse than one that wanders,
each view keeps a shift of its own.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.joint import State, fit_to_pairs
from fusion.turntable.all_views.loop import LoopSettings, close_loop
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.agreeing import NEIGHBOURS, agreeing, places_between
from fusion.turntable.guess.decided import POINTS_JOINT, Alone, best_partners, decided, nothing_turns
from fusion.turntable.guess.everywhere import listen
from fusion.turntable.guess.labels import consistent, unwound
from fusion.turntable.guess.start import axis_guesses, axis_through
from fusion.turntable.pairs.edges import CLEAR, FEWEST, ViewStack, above, stack, thinned_view
from fusion.turntable.table.foot import foot_normal, plate_among
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
POINTS = 800  # source points per frame
KEYS = 24  # views of which all pairs are compared; the others find their place between them
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


def find_alone(views: Sequence[ObjectView], region: Region) -> Alone:
    """Axis and angles of views (n) of the object.

    Raises:
        TrackingError: the views do not fit turns about one axis.
    """
    n = len(views)
    keys = np.unique(np.linspace(0, n - 1, min(n, KEYS)).round().astype(int))
    plate = plate_among(views)
    if plate is not None:  # it turns into itself: what fits it best is no turn at all
        clear = [above(v, Axis(*plate), CLEAR, len(v.points)) for v in views]
        views, plate = (clear, plate) if min(len(v.points) for v in clear) >= FEWEST else (views, None)
    seen = stack([thinned_view(v, POINTS) for v in views])
    axis = upright_axis(views, seen, region, keys, None if plate is None else plate[1])
    pairs = [(int(i), int(j)) for k, i in enumerate(keys) for j in keys[k + 1 :]]
    heard = listen(seen, axis, pairs)
    printed = heard.printed()
    place = np.full(n, -1)
    place[keys] = np.arange(len(keys))
    said = heard.said(printed)
    turns = np.full(n, np.nan)
    turns[keys] = consistent(len(keys), replace(said, pairs=place[said.pairs]))
    edges, poses, worth = agreeing(heard, printed, turns)
    if len(keys) < n:
        between = places_between(seen, axis, keys, turns, printed)
        edges, poses, worth = edges + between[0], np.concatenate([poses, between[1]]), np.append(worth, between[2])
    if not edges:
        raise nothing_turns(1.0)
    angles = unwound(turns)
    state = fit_to_pairs(State(axis, angles, np.zeros((n, 2))), edges, poses, worth)
    return decided(stack([thinned_view(v, POINTS_JOINT) for v in views]), state, best_partners(edges, worth, n))


def found_again(views: Sequence[ObjectView], start: State) -> Alone:
    """The motion of views (n) that is known but for what pulled some of them: no turn is sought anew.

    Raises:
        TrackingError: the views do not fit turns about one axis.
    """
    n = len(views)
    i, j = np.triu_indices(n, 1)
    apart = np.abs((start.angles[j] - start.angles[i] + np.pi) % (2 * np.pi) - np.pi)
    near = (apart < NEIGHBOURS) | (j == i + 1)
    edges = list(zip(i[near].tolist(), j[near].tolist(), strict=True))
    # partners of all distances: the nearest alone, as those of a hand at rest, would say nothing of the rest
    worth = np.random.default_rng(0).uniform(size=len(edges))
    return decided(stack([thinned_view(v, POINTS_JOINT) for v in views]), start, best_partners(edges, worth, n))
