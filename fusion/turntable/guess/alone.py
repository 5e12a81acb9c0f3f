"""The motion when nothing is told: all pairs of views are compared at all turns, and one motion agrees with most.

Neighbours need not be near: a hand turns by 10 degrees or by 60, stops, or goes back, and the first view that comes
again closes the loop by itself. A hand also moves the object; where one axis fits clearly worse than one that wanders,
each view keeps a shift of its own.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.joint import NOTHING, PairMotions, State, fit_to_pairs
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.below.told import COUNTS, told_below
from fusion.turntable.guess.agreeing import NEIGHBOURS, agreeing, places_between
from fusion.turntable.guess.decided import (
    POINTS_JOINT,
    Alone,
    best_partners,
    decided,
    held_by_print,
    nothing_turns,
    printed,
)
from fusion.turntable.guess.everywhere import listen
from fusion.turntable.guess.labels import consistent, unwound
from fusion.turntable.guess.upright import upright_axis
from fusion.turntable.pairs.edges import CLEAR, FEWEST, Edges, above, stack, thinned_view
from fusion.turntable.table.foot import plate_among
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
POINTS = 800  # source points per frame
KEYS = 24  # views of which all pairs are compared; the others find their place between them


def find_alone(views: Sequence[ObjectView], region: Region) -> Alone:
    """Axis and angles of views (n) of the object.

    Raises:
        TrackingError: the views do not fit turns about one axis.
    """
    n = len(views)
    marked = np.unique([0, *np.flatnonzero([v.marks is not None for v in views]), n - 1])
    below = told_below(region.below, [views[k].marks for k in marked])
    keys = np.unique(np.linspace(0, n - 1, min(n, KEYS)).round().astype(int)) if below is None else marked
    plate = plate_among(views)
    if plate is not None:  # it turns into itself: what fits it best is no turn at all
        clear = [above(v, Axis(*plate), CLEAR, len(v.points)) for v in views]
        views, plate = (clear, plate) if min(len(v.points) for v in clear) >= FEWEST else (views, None)
    seen = stack([thinned_view(v, POINTS) for v in views])
    foot = plate[1] if plate is not None else None if below is None else below.upright.direction
    axis = upright_axis(views, seen, region, keys, foot)
    pairs = [(int(i), int(j)) for k, i in enumerate(keys) for j in keys[k + 1 :]]
    heard = listen(seen, axis, pairs)
    printed = heard.printed()
    place = np.full(n, -1)
    place[keys] = np.arange(len(keys))
    said = heard.said(printed)
    said = replace(said, pairs=place[said.pairs])
    turns = np.full(n, np.nan)
    turns[keys] = consistent(len(keys), said if below is None else said.beside(below.said()))
    edges, poses, worth = agreeing(heard, printed, turns)
    told = NOTHING if below is None else below.agreeing(turns[keys], keys)
    if len(keys) < n:
        between = places_between(seen, axis, keys, turns, printed)
        edges, poses, worth = edges + between[0], np.concatenate([poses, between[1]]), np.append(worth, between[2])
    if not edges and not told.edges:
        raise nothing_turns(1.0)
    angles = unwound(turns)
    all_pairs = PairMotions(
        edges + told.edges, np.concatenate([poses, told.poses]), np.append(worth, COUNTS * told.worth)
    )
    state = fit_to_pairs(State(axis, angles, np.zeros((n, 2))), all_pairs)
    partners = best_partners(all_pairs.edges, all_pairs.worth, n)
    return decided(stack([thinned_view(v, POINTS_JOINT) for v in views]), state, partners, told)


def found_again(views: Sequence[ObjectView], start: State) -> Alone:
    """The motion of views (n) that is known but for what pulled some of them: no turn is sought anew.

    Raises:
        TrackingError: the views do not fit turns about one axis.
    """
    return decided(stack([thinned_view(v, POINTS_JOINT) for v in views]), start, _near_in_turn(start.angles))


def held_through(views: Sequence[ObjectView], motion: Turns) -> Alone | None:
    """The motion of views (n) that was told, made better by print where shape lets it slip; None where shape holds it.

    Such an object is nearly round, and shape tells of its axis as little as of its turn.
    """
    if any(v.print is None for v in views):
        return None
    seen, state = stack([thinned_view(v, POINTS_JOINT) for v in views]), State(*motion, np.zeros((len(views), 2)))
    edges = _near_in_turn(motion.angles)
    return printed(seen, (state, state), edges) if held_by_print(seen, state, edges) else None


def _near_in_turn(angles: Array) -> Edges:
    """Both ways, each view with some of those that are turned little from it; angles (n,) [rad]."""
    i, j = np.triu_indices(len(angles), 1)
    apart = np.abs((angles[j] - angles[i] + np.pi) % (2 * np.pi) - np.pi)
    near = (apart < NEIGHBOURS) | (j == i + 1)
    edges = list(zip(i[near].tolist(), j[near].tolist(), strict=True))
    # partners of all distances: the nearest alone, as those of a hand at rest, would say nothing of the rest
    worth = np.random.default_rng(0).uniform(size=len(edges))
    return best_partners(edges, worth, len(angles))
