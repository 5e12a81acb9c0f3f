"""The motion when nothing is told: all pairs of views are compared at all turns, and one motion agrees with most.

Neighbours need not be near: a hand turns by 10 degrees or by 60, stops, or goes back, and the first view that comes
again closes the loop by itself. A hand also moves the object; where one axis fits clearly worse than one that wanders,
each view keeps a shift of its own.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.all_views.joint import NOTHING, PairMotions, State, fit_to_pairs
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.below.told import COUNTS, told_below
from fusion.turntable.guess.agreeing import NEIGHBOURS, agreeing, places_between
from fusion.turntable.guess.decided import (
    JOINT,
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
from fusion.turntable.pairs.edges import CLEAR, FEWEST, Edges, ViewStack, above, stack, thinned_view
from fusion.turntable.pairs.pairwise import Twists, twists
from fusion.turntable.table.foot import plate_among
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
POINTS = 800  # source points per frame
# misfit of views that turn the other way over that as told, below which shape does not say which: guess between the 1
# of round things and the 14 to 50 of five others, two of them round and off the axis
EITHER = 2.0
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

    Such an object is nearly round, and shape tells of its axis as little as of its turn; of a round one not even which
    way it turned, which no log and no step say.
    """
    if any(v.print is None for v in views):
        return None
    seen, edges = stack([thinned_view(v, POINTS_JOINT) for v in views]), _near_in_turn(motion.angles)
    told, back = (State(motion.axis, way * motion.angles, np.zeros((len(views), 2))) for way in (1.0, -1.0))
    here, there = _lying(seen, told, edges), _lying(seen, back, edges)
    if here.printed.any() and np.median(there.misfit) < EITHER * np.median(here.misfit):
        best = back if _alike(there) > _alike(here) else told
        return printed(seen, (best, best), edges)
    return printed(seen, (told, told), edges) if held_by_print(seen, told, edges) else None


def _lying(seen: ViewStack, state: State, edges: Edges) -> Twists:
    """What pairs of views say where a motion puts them."""
    i, j = np.array(edges).T
    poses = state.motions()
    return twists(seen, edges, poses[j] @ pose.inverse(poses[i]), state.axis.point, JOINT[-1])


def _alike(at: Twists) -> float:
    """How much alike print is, -1 to 1: mean over what was compared."""
    return float(np.average(at.alike, weights=at.printed)) if at.printed.any() else -1.0


def _near_in_turn(angles: Array) -> Edges:
    """Both ways, each view with some of those that are turned little from it; angles (n,) [rad]."""
    i, j = np.triu_indices(len(angles), 1)
    apart = np.abs((angles[j] - angles[i] + np.pi) % (2 * np.pi) - np.pi)
    near = (apart < NEIGHBOURS) | (j == i + 1)
    edges = list(zip(i[near].tolist(), j[near].tolist(), strict=True))
    # partners of all distances: the nearest alone, as those of a hand at rest, would say nothing of the rest
    worth = np.random.default_rng(0).uniform(size=len(edges))
    return best_partners(edges, worth, len(angles))
