"""All views at once by shape and print: one axis, one turn for each view, and where a hand moved it across the axis.

What each pair of views says of a small motion of one against the other is six equations (see `pairwise`), and one for
the focal length; a motion of a view is a turn about the axis and a shift across it, and the axis itself leans and
moves for all views together.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.geometry import pose
from fusion.geometry.robust import EFFECTIVE
from fusion.turntable.axis import Axis
from fusion.turntable.pairs.edges import Edges, ViewStack
from fusion.turntable.pairs.pairwise import Twists, ViewPairLimits, twists
from fusion.turntable.pairs.twist_system import SHARED, normal_equations, planar, planar_columns
from fusion.turntable.selfcheck import PRIOR

Array = NDArray[np.float64]
FEWEST = 100  # pairs of points that make an edge (guess)
WORST = 0.6  # misfit of an edge that is left out (guess)
# [rad], [m] what a pair of views may be off (guess): by what cameras bend of depth, whatever they look at
ANGLE, SHIFT = np.deg2rad(1.5), 0.002
WIDE = 0.03  # [m] reach within which the spread of views is taken: above what any camera is off by
FOCAL = float(PRIOR[0])
SETTLED = 2e-5  # [rad], [m] a hundredth of a camera's noise
FIXED = 1e-6  # [m] an axis that stays where it is


@dataclass(frozen=True)
class State:
    """A motion of n views."""

    axis: Axis  # in the camera's frame
    angles: Array  # (n,) [rad]
    shifts: Array  # (n, 2) of the object along `axis.across()` [m], after the turn
    focal: float = 0.0  # log of the focal length over the stated one

    def of(self, chosen: NDArray[np.intp]) -> "State":
        """The motion of some of the views."""
        return replace(self, angles=self.angles[chosen], shifts=self.shifts[chosen])

    def motions(self) -> Array:
        """(n, 4, 4) what brings the object from its mean place, turned as at angle 0, to that in each view."""
        return planar(self.axis, self.angles, self.shifts)


@dataclass(frozen=True)
class Joint:
    """What the views say together."""

    state: State  # the motion
    # angle_std, shift_std: (n,), (n,) [rad], [m]
    angle_std: Array
    shift_std: Array
    focal_std: float  # of the log of the focal length
    # misfit, scale: (n,) of each view with its partners: share of the points that do not fit; observed over declared
    # spread of depth
    misfit: Array
    scale: Array
    spread: float  # rms distance of views from each other along the normal [m]
    at: Twists  # what the edges say there

    @property
    def gaps(self) -> Array:
        """(m,) by how much each edge misses what it says itself of turn and shifts, in variances; NaN: it says nothing.

        As many as its three freedoms where noise alone makes them, and that of each point is its own.
        """
        own = planar_columns(self.state.axis)
        H, g = own.T @ self.at.H[:, :6, :6] @ own, self.at.g[:, :6] @ own
        size = np.sqrt(np.diagonal(H, axis1=1, axis2=2)) + 1e-12
        inverse = np.linalg.pinv(H / (size[:, :, None] * size[:, None]), rcond=1e-6, hermitian=True)
        said = np.einsum("mi,mij,mj->m", g / size, inverse, g / size)
        return np.where(_tells(self.at), said, np.nan)


@dataclass(frozen=True)
class Free:
    """What a joint fit may change."""

    loose: float  # standard deviation of the shifts [m]; `FIXED` for a turntable
    axis: bool = True  # the axis too
    focal: bool = False  # the focal length too


@dataclass(frozen=True)
class PairMotions:
    """Motions of pairs of views that something else says than their points."""

    edges: Edges  # m pairs: source and model view
    poses: Array  # (m, 4, 4) model from source
    worth: Array  # (m,) how much each counts
    # what they may be off: turn [rad], shift [m]
    angle: float = ANGLE
    shift: float = SHIFT

    def said(self, now: Array, axis: Axis, centre: Array) -> Twists:
        """Their equations where the pairs lie so now (m, 4, 4); what does not fit in counts less (Cauchy's weights)."""
        size = np.array([self.angle, self.shift, self.shift])
        own = np.vstack([planar_columns(axis), np.zeros((1, 3))])
        D = self.poses @ pose.inverse(now)
        turn = Rotation.from_matrix(D[:, :3, :3]).as_rotvec() @ axis.direction
        shift = (np.einsum("mij,j->mi", D[:, :3, :3], centre) + D[:, :3, 3] - centre) @ axis.across().T
        off = np.column_stack([turn, shift])
        weight = self.worth / (1 + np.sum((off / size) ** 2, axis=1)) / EFFECTIVE
        H = weight[:, None, None] * ((own / size**2) @ own.T)
        g = -weight[:, None] * ((off / size**2) @ own.T)
        none = np.zeros(len(self.edges))
        return Twists(H, g, none, none + 2 * FEWEST, none, none, none, none, none)


NOTHING = PairMotions([], np.zeros((0, 4, 4)), np.zeros(0))


@dataclass(frozen=True)
class _Last:
    std: Array = field(default_factory=lambda: np.zeros(0))
    found: Twists | None = None


def fit_jointly(
    seen: ViewStack,
    start: State,
    edges: Edges,
    passes: tuple[ViewPairLimits, ...],
    free: Free,
    iterations: int = 5,
    told: PairMotions = NOTHING,
) -> Joint:
    """Refine a motion.

    Args:
        seen: the views.
        start: where to begin.
        edges: pairs of views.
        passes: limits, one after the other.
        free: what may change.
        iterations: in each pass.
        told: what else is known of pairs.
    """
    state, last, m = start, _Last(), len(edges)
    for limits in passes:

        def say(poses: Array, state: State, limits: ViewPairLimits = limits) -> Twists:
            found = twists(seen, edges, poses[:m], state.axis.point, limits, state.focal)
            return found.beside(told.said(poses[m:], state.axis, state.axis.point))

        state, last = _fit(state, edges + told.edges, say, free, iterations)
    assert last.found is not None
    found = last.found.first(m)
    n, i = len(state.angles), np.array(edges, np.intp)[:, 0]
    count = np.maximum(np.bincount(i, minlength=n), 1)
    misfit, scale = (np.bincount(i, k, n) / count for k in (found.misfit, found.scale))
    own = last.std[SHARED:].reshape(n, 3)
    return Joint(
        state, own[:, 0], np.hypot(own[:, 1], own[:, 2]), float(last.std[SHARED - 1]), misfit, scale,
        _spread(seen, state, edges), found,
    )  # fmt: skip


def fit_to_pairs(start: State, told: PairMotions, iterations: int = 15) -> State:
    """The motion about a known axis that agrees with those of pairs of views."""

    def say(now: Array, state: State) -> Twists:
        return told.said(now, start.axis, state.axis.point)

    return _fit(start, told.edges, say, Free(1.0, axis=False), iterations)[0]


def angle_stds(
    seen: ViewStack, state: State, edges: Edges, limits: ViewPairLimits, told: PairMotions = NOTHING
) -> Array:
    """Standard deviations (n,) of the angles [rad] where a fit about one axis stands; infinite where nothing tells."""
    M, m = state.motions(), len(edges)
    i, j = np.array(edges + told.edges, np.intp).T
    now = M[j] @ pose.inverse(M[i])
    found = twists(seen, edges, now[:m], state.axis.point, limits, state.focal)
    found = found.beside(told.said(now[m:], state.axis, state.axis.point))
    H, _ = normal_equations(found, state.axis, M, (i, j), np.where(_tells(found), EFFECTIVE, 0.0))
    turns = SHARED + 3 * np.arange(1, len(M))
    kept = np.append(np.arange(4), turns)
    values = H[np.ix_(kept, kept)] + np.diag(
        np.append(1 / np.array([0.1, 0.1, 0.02, 0.02]) ** 2, np.full(len(turns), 1e-3))
    )
    return np.append(0.0, np.sqrt(np.diag(np.linalg.inv(values))[4:]))


def _fit(
    state: State, edges: Edges, say: Callable[[Array, State], Twists], free: Free, iterations: int
) -> tuple[State, _Last]:
    n, last = len(state.angles), _Last()
    i, j = np.array(edges, np.intp).T
    held = np.zeros(SHARED + 3 * n, bool)
    held[: SHARED - 1], held[SHARED - 1] = not free.axis, not free.focal
    held[SHARED] = True  # the first view is not turned
    across = (SHARED + np.arange(3 * n).reshape(n, 3)[:, 1:]).ravel()
    for _ in range(iterations):
        M = state.motions()
        found = say(M[j] @ pose.inverse(M[i]), state)
        H, g = normal_equations(found, state.axis, M, (i, j), np.where(_tells(found), EFFECTIVE, 0.0))
        H[across, across] += 1 / free.loose**2
        g[across] += state.shifts.ravel() / free.loose**2
        H[SHARED - 1, SHARED - 1] += 1 / FOCAL**2
        g[SHARED - 1] += state.focal / FOCAL**2
        step, std = _solve(H, g, held)
        last = _Last(std, found)
        state = _moved(state, step)
        if np.abs(step).max() < SETTLED:
            break
    return state, last


def _tells(found: Twists) -> NDArray[np.bool_]:
    """(m,) edges that take part."""
    return np.asarray((found.misfit < WORST) & (found.pairs > FEWEST))


def _spread(seen: ViewStack, state: State, edges: Edges) -> float:
    M = state.motions()
    i, j = np.array(edges, np.intp).T
    limits = ViewPairLimits(WIDE, -1.0)
    at = twists(seen, edges, M[j] @ pose.inverse(M[i]), state.axis.point, limits, state.focal)
    squares = at.misfit * at.visible - (at.visible - at.pairs)  # of pairs, in units of half the reach
    return float(seen.reach(WIDE) / 2 * np.sqrt(max(squares.sum(), 0.0) / max(at.pairs.sum(), 1)))


def _solve(H: Array, g: Array, held: NDArray[np.bool_]) -> tuple[Array, Array]:
    free = (np.diag(H) > 0) & ~held
    size = np.sqrt(np.diag(H)[free]) + 1e-12
    inverse = np.linalg.pinv(H[np.ix_(free, free)] / np.outer(size, size), rcond=1e-9, hermitian=True)
    inverse /= np.outer(size, size)
    step, std = np.zeros((2, len(g)))
    step[free] = -inverse @ g[free]
    std[free] = np.sqrt(np.maximum(np.diag(inverse), 0))
    return step * min(1.0, 0.1 / max(float(np.abs(step).max()), 1e-12)), std


def _moved(state: State, step: Array) -> State:
    own = step[SHARED:].reshape(-1, 3)
    first, second = state.axis.across()
    sign = np.sign(np.cross(first, second) @ state.axis.direction)
    c, s = np.cos(own[:, 0]), sign * np.sin(own[:, 0])
    x, y = state.shifts.T  # a step turns about the axis' point after the shift
    shifts = np.column_stack([c * x - s * y, s * x + c * y]) + own[:, 1:]
    focal = state.focal + float(step[SHARED - 1])
    return replace(state, axis=state.axis.moved(step[:4]), angles=state.angles + own[:, 0], shifts=shifts, focal=focal)
