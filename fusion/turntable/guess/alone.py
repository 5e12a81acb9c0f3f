"""The motion when nothing is told: all pairs of views are compared at all turns, and one motion agrees with most.

Neighbours need not be near: a hand turns by 10 degrees or by 60, stops, or goes back, and the first view that comes
again closes the loop by itself. A hand also moves the object; where one axis fits clearly worse than one that wanders,
each view keeps a shift of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.turntable.all_views.joint import FIXED, Free, Joint, State, angle_stds, fit_jointly, fit_to_pairs
from fusion.turntable.all_views.loop import LoopSettings, close_loop
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.everywhere import Heard, listen
from fusion.turntable.guess.labels import consistent, unwound
from fusion.turntable.guess.start import axis_guesses
from fusion.turntable.pairs.edges import Edges, ViewStack, stack
from fusion.turntable.pairs.pairwise import ViewPairLimits
from fusion.turntable.table.foot import axis_through, foot_normal, plate_among
from fusion.turntable.table.plate import above
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
KEYS = 24  # views of which all pairs are compared; the others find their place between them
POINTS, POINTS_JOINT = 800, 2000
CLEAR = 0.008  # [m] above a plate both are seen in one pixel (guess)
FEWEST = 150  # points of a view above it, or they are kept
SOME = 4  # views that show what is behind them all
PROBED = 8  # neighbours that tell the axis
NEIGHBOURS = np.deg2rad(75)  # largest turn between these that is tried (guess)
AGREES = np.deg2rad(8)  # of a pair and the labels (guess)
LEAST = 0.25  # worth of a pair that takes part (guess)
PARTNERS = 8  # of a view in the joint fit
# spread of the views about one fixed axis over that about a wandering one: 1.00 to 1.05 on tables, 1.3 and more where a
# hand moved the object by what noise does not hide (guess)
WANDERS = 1.15
SLIPS = 2.0  # standard deviations of the angles by shape alone over those with print: shape lets them slip (guess)
HOPELESS = 0.5  # misfit of views that do not turn about any axis (guess)
JOINT = (ViewPairLimits(0.01, 2.0, 0.12, 1000), ViewPairLimits(0.006, 2.0, 0.12, POINTS_JOINT))
COARSE = (ViewPairLimits(0.02, 0.0, 0.24, 600), *JOINT)


@dataclass(frozen=True)
class Alone:
    """A motion found without any hint.

    Attributes:
        state: axis, angles and shifts.
        joint: the fit behind it.
        lens: the fit with the focal length free where a hand turned the object about no fixed axis, or where print
            holds what shape lets slip; None where shape and one axis do.
        wanders: a hand moved the object.
    """

    state: State
    joint: Joint
    lens: Joint | None
    wanders: bool = False


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
    seen = stack([_thin(v, POINTS) for v in views])
    axis = _upright(views, seen, region, keys, None if plate is None else plate[1])
    pairs = [(int(i), int(j)) for k, i in enumerate(keys) for j in keys[k + 1 :]]
    heard = listen(seen, axis, pairs)
    printed = heard.printed()
    place = np.full(n, -1)
    place[keys] = np.arange(len(keys))
    said = heard.said(printed)
    turns = np.full(n, np.nan)
    turns[keys] = consistent(len(keys), replace(said, pairs=place[said.pairs]))
    edges, poses, worth = _agreeing(heard, printed, turns)
    if len(keys) < n:
        between = _between(seen, axis, keys, turns, printed)
        edges, poses, worth = edges + between[0], np.concatenate([poses, between[1]]), np.append(worth, between[2])
    if not edges:
        raise _nothing_turns(1.0)
    angles = unwound(turns)
    state = fit_to_pairs(State(axis, angles, np.zeros((n, 2))), edges, poses, worth)
    return _decided(stack([_thin(v, POINTS_JOINT) for v in views]), state, _chosen(edges, worth, n))


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
    return _decided(stack([_thin(v, POINTS_JOINT) for v in views]), start, _chosen(edges, worth, n))


def _thin(view: ObjectView, most: int) -> ObjectView:
    return above(view, Axis(np.zeros(3), np.array([0.0, -1.0, 0.0])), -np.inf, most)


def _upright(
    views: Sequence[ObjectView], seen: ViewStack, region: Region, keys: NDArray[np.intp], foot: Array | None
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


def _agreeing(heard: Heard, printed: float, turns: Array) -> tuple[Edges, Array, Array]:
    """The best candidate of each pair that agrees with turns (n,): edges, motions (m, 4, 4), worth (m,)."""
    worth = heard.worth(printed)
    best: dict[tuple[int, int], int] = {}
    for k, (i, j) in enumerate(heard.edges):
        off = (heard.found.turns[k] - turns[j] + turns[i] + np.pi) % (2 * np.pi) - np.pi
        if abs(off) < AGREES and worth[k] > LEAST and ((i, j) not in best or worth[k] > worth[best[i, j]]):
            best[i, j] = k
    chosen = list(best.values())
    return list(best), heard.found.poses[chosen], worth[chosen]


def _between(
    seen: ViewStack, axis: Axis, keys: NDArray[np.intp], turns: Array, printed: float
) -> tuple[Edges, Array, Array]:
    """Places `turns` of the views between keys, by the keys before and after; what they say, as `_agreeing`."""
    others = np.flatnonzero(np.isnan(turns))
    after = np.searchsorted(keys, others)
    pairs = [(int(keys[a - k]), int(o)) for a, o in zip(after, others, strict=True) for k in (1, 0)]
    heard = listen(seen, axis, pairs, NEIGHBOURS)
    said = heard.said(printed)
    for o, a in zip(others, after, strict=True):
        first, second = keys[a - 1], keys[a]
        rest = (turns[second] - turns[first] + np.pi) % (2 * np.pi) - np.pi
        share = (o - first) / (second - first)
        turns[o] = turns[first] + share * rest
        mine = np.flatnonzero(said.pairs[:, 1] == o)
        at = turns[said.pairs[mine, 0]] + said.turns[mine]
        if len(mine):
            apart = (at[:, None] - at + np.pi) % (2 * np.pi) - np.pi
            # what both say; of equals the one nearer to an even hand
            off = (at - turns[o] + np.pi) % (2 * np.pi) - np.pi
            votes = np.exp(-0.5 * (apart / np.deg2rad(3)) ** 2) @ said.worth[mine] * (1 - 0.1 * np.abs(off))
            turns[o] = at[int(np.argmax(votes))]
    return _agreeing(heard, printed, turns)


def _chosen(edges: Edges, worth: Array, n: int) -> Edges:
    """Both ways, each view with its best partners."""
    kept: set[tuple[int, int]] = set()
    order = np.argsort(-worth, kind="stable")
    count = np.zeros(n, int)
    for k in order:
        i, j = edges[k]
        if count[i] < PARTNERS or count[j] < PARTNERS or abs(i - j) == 1:
            kept |= {(i, j), (j, i)}
            count[[i, j]] += 1
    return sorted(kept)


def _decided(seen: ViewStack, state: State, edges: Edges) -> Alone:
    """The joint fit, of one axis where that does."""
    wide = fit_jointly(seen, state, edges, JOINT, Free(1.0))
    misfit = float(np.median(wide.at.misfit))
    if misfit > HOPELESS:
        raise _nothing_turns(misfit)
    shifts = wide.state.shifts - wide.state.shifts.mean(axis=0)
    start = replace(wide.state, shifts=0 * shifts)
    narrow = fit_jointly(seen, start, edges, COARSE, Free(FIXED, focal=True))
    if narrow.spread < WANDERS * wide.spread:
        if not held_by_print(seen, narrow, edges):
            return Alone(narrow.state, narrow, None)
        stated = fit_jointly(seen, replace(narrow.state, focal=0.0), edges, JOINT, Free(FIXED))
        return Alone(stated.state, stated, narrow)
    # a hand does not move the object so that a wrong focal length keeps it in shape
    lens = fit_jointly(seen, wide.state, edges, (JOINT[0], *JOINT), Free(1.0, focal=True))
    return Alone(wide.state, wide, lens, wanders=True)


def held_by_print(seen: ViewStack, found: Joint, edges: Edges) -> bool:
    """Whether it is mostly print that tells the angles: without it they would be known clearly worse."""
    if not len(seen.tones):
        return False
    both, shape = (
        angle_stds(seen, found.state, edges, replace(JOINT[-1], tone=tone)) for tone in (JOINT[-1].tone, 0.0)
    )
    return bool(np.median(shape[1:]) > SLIPS * np.median(both[1:]))


def _nothing_turns(misfit: float) -> TrackingError:
    return TrackingError(
        "the views do not fit a turn about one axis",
        found=f"a misfit of {misfit:.2f}",
        expected=f"below {HOPELESS:g}",
        do="check that the camera stood still and that views overlap (60 degrees or less); what a hand moves freely, "
        "about no axis, is no turntable scan: `fusion reconstruct` with --box follows it",
    )
