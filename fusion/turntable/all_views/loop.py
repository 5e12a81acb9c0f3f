"""Close the loop: one rigid axis and one angle per frame, refined jointly over overlapping views of all turns.

Every pair of overlapping views gives point-to-plane equations. They are linear in small changes of the axis (4), the
two angles and, on request, the camera; so thousands of pairs per edge shrink to one small normal matrix, and drift
and the closing gap vanish in one least-squares solution instead of being spread afterwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from fusion.geometry.robust import EFFECTIVE
from fusion.turntable.all_views.log import log_equations
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.pairs.edges import AskedErrors, Sums, ViewStack, edge_sums, stack
from fusion.turntable.selfcheck import NAMES, SelfCheck, no_errors
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]


MOST = 4.0  # errors of the camera stay within this many prior standard deviations
SETTLED = 0.1  # standard deviations: a shorter step, all unknowns together, changes nothing that the views tell
COARSE_POINTS = 30_000  # of all frames together, in all passes but the last: they only have to come near
SHARED = 4  # steps of the axis
FIRST = SHARED + len(NAMES)  # column of the first angle


@dataclass(frozen=True)
class Loop:
    """A turntable motion and how well it fits."""

    axis: Axis  # in the camera's frame
    angles: Array  # (n,) turn of each frame [rad], 0 at the first; NaN for a frame left out
    angle_std: Array  # (n,) standard deviation from the fit, noise taken as independent [rad]
    residual: Array  # (n,) rms of a frame's pairs [m]
    support: Array  # (n,) share of a frame's visible points that fit
    pairs: Array  # (n,) how many fit
    check: SelfCheck  # errors of camera and depth that were fitted, zero where they were not
    check_std: Array  # (13,) their standard deviations from the fit, noise taken as independent


@dataclass(frozen=True)
class LoopSettings:
    """Passes of the joint fit."""

    reaches: tuple[float, ...] = (0.03, 0.015, 0.008)  # largest distance of a pair in each pass [m]
    iterations: tuple[int, ...] = (6, 4, 4)  # in each pass
    # free_axis, free_angles: False keeps them as they are
    free_axis: bool = True
    free_angles: bool = True
    free_camera: tuple[str, ...] = ()  # names of `selfcheck.NAMES` that are fitted too
    # (n,) angles [rad] as the table's log says, of the sign of the motion; None where nothing is known
    told: Array | None = None


@dataclass
class _System:
    """Normal equations in [axis (4), camera (13), angles (n)] and the book-keeping per frame."""

    n: int
    H: Array = field(init=False)
    g: Array = field(init=False)
    squares: Array = field(init=False)
    fitting: Array = field(init=False)
    visible: Array = field(init=False)

    def __post_init__(self) -> None:
        self.H = np.zeros((FIRST + self.n, FIRST + self.n))
        self.g = np.zeros(FIRST + self.n)
        self.squares, self.fitting, self.visible = np.zeros((3, self.n))


def choose_edges(
    angles: Array, widest: float = np.deg2rad(35), per_frame: int = 6, farthest: float = np.inf
) -> list[tuple[int, int]]:
    """Pairs of frames (i, j) whose views overlap.

    Errors that stand still in the image pull a small turn towards zero, so neighbours closer than 8 degrees are left
    out, unless they come from another turn, where zero is nearly the truth.

    Args:
        angles: (n,) unwrapped [rad], NaN for frames left out.
        widest: largest turn between the two [rad]; half as much again where nothing is nearer on that side.
        per_frame: how many partners to give a frame.
        farthest: turn between the two with all whole turns counted [rad].
    """
    closest = np.deg2rad(8)
    known = np.flatnonzero(np.isfinite(angles))
    edges: set[tuple[int, int]] = set()
    for position, i in enumerate(known):
        others = known[(known != i) & (np.abs(angles[known] - angles[i]) < farthest)]
        turn = _wrap(angles[others] - angles[i])
        telling = (np.abs(turn) >= closest) | (np.abs(angles[others] - angles[i]) > np.pi)
        picks: set[int] = set()
        for side in (-1, 1):
            here = telling & (side * turn >= 0)
            near = others[here & (np.abs(turn) <= widest)]
            if len(near) == 0:  # the stretch that was not recorded: reach over it
                near = others[here & (np.abs(turn) <= 1.5 * widest)]
            if len(near):
                order = near[np.argsort(np.abs(_wrap(angles[near] - angles[i])), kind="stable")]
                spread = np.linspace(0, len(order) - 1, min(len(order), per_frame // 2)).round().astype(int)
                picks.update(int(k) for k in order[spread])
        if not picks and position + 1 < len(known):
            picks.add(int(known[position + 1]))
        edges.update((int(i), k) for k in picks)
    return sorted(edges)


def close_loop(
    views: Sequence[ObjectView] | ViewStack,
    motion: Turns,
    edges: list[tuple[int, int]],
    settings: LoopSettings | None = None,
    check: SelfCheck | None = None,
) -> Loop:
    """Refine axis and angles.

    Args:
        views: (n) one per frame, as the camera file has them; stacked where several fits share them.
        motion: first guess of the axis and the angles (n,) [rad]; NaN angles stay out.
        edges: pairs of frames that overlap.
        settings: passes.
        check: errors of camera and depth to start from.
    """
    settings = settings or LoopSettings()
    axis, angles = motion[0], np.array(motion[1], float)
    seen = views if isinstance(views, ViewStack) else stack(views)
    check = check or no_errors(seen.views)
    n = len(seen.views)
    system = _System(n)
    for reach, iterations in zip(settings.reaches, settings.iterations, strict=True):
        some = seen if reach == settings.reaches[-1] else seen.thinned(COARSE_POINTS)
        for _ in range(iterations):
            system = _System(n)
            asked = AskedErrors(check, settings.free_camera)
            _add_edges(system, edges, edge_sums(some, Turns(axis, angles), edges, reach, asked))
            _add_prior(system, check)
            if settings.told is not None:
                _add_log(system, angles, settings.told)
            step = _solve(system, angles, settings, check)
            axis = axis.moved(step[:SHARED])
            check = replace(check, values=check.values + step[SHARED:FIRST])
            angles = angles + np.where(np.isfinite(angles), step[FIRST:], 0)
            angles -= angles[np.isfinite(angles)][0]
            if abs(system.g @ step) < SETTLED**2:  # Newton's decrement, step' H step
                break
    free = ~_held(system, angles, settings)
    std = np.zeros(len(system.g))
    std[free] = np.sqrt(np.maximum(np.diag(np.linalg.pinv(system.H[np.ix_(free, free)], hermitian=True)), 0))
    residual = np.sqrt(system.squares / np.maximum(system.fitting, 1))
    support = system.fitting / np.maximum(system.visible, 1)
    angle_std = np.where(np.isfinite(angles), std[FIRST:], np.nan)
    return Loop(axis, angles, angle_std, residual, support, system.fitting, check, std[SHARED:FIRST])


def _add_prior(system: _System, check: SelfCheck) -> None:
    """The camera file is not nonsense: its errors have a plausible size."""
    block = np.arange(SHARED, FIRST)
    system.H[block, block] += 1 / check.prior**2
    system.g[block] += check.values / check.prior**2


def _add_log(system: _System, angles: Array, told: Array) -> None:
    """What the log says of every step, see `log_equations`."""
    known, weight, excess = log_equations(angles, told)
    before, after = FIRST + known[:-1], FIRST + known[1:]
    for frame, sign in ((before, -1), (after, 1)):
        np.add.at(system.g, frame, sign * weight * excess)
        np.add.at(system.H, (frame, frame), weight)
    np.add.at(system.H, (before, after), -weight)
    np.add.at(system.H, (after, before), -weight)


def _add_edges(system: _System, edges: list[tuple[int, int]], sums: Sums) -> None:
    H, g = EFFECTIVE * sums.H, EFFECTIVE * sums.g
    i, j = np.array(edges).T
    wide = slice(0, H.shape[1] - 1)  # axis, and camera where it is free
    system.H[wide, wide] += H[:, 1:, 1:].sum(axis=0)
    system.g[wide] += g[:, 1:].sum(axis=0)
    for frame, sign in ((j, 1), (i, -1)):  # the turn is angle_j - angle_i
        np.add.at(system.H[:, wide], FIRST + frame, sign * H[:, 0, 1:])
        np.add.at(system.H.T[:, wide], FIRST + frame, sign * H[:, 0, 1:])
        np.add.at(system.g, FIRST + frame, sign * g[:, 0])
        for other, its_sign in ((j, 1), (i, -1)):
            np.add.at(system.H, (FIRST + frame, FIRST + other), sign * its_sign * H[:, 0, 0])
        np.add.at(system.squares, frame, sums.squares)
        np.add.at(system.fitting, frame, sums.fitting)
        np.add.at(system.visible, frame, sums.visible)


def _held(system: _System, angles: Array, settings: LoopSettings) -> NDArray[np.bool_]:
    """Unknowns that stay as they are: the first used frame, what was not asked for, what has no equations."""
    held = np.diag(system.H) <= 0
    held[:SHARED] |= not settings.free_axis
    held[SHARED:FIRST] = [name not in settings.free_camera for name in NAMES]
    held[FIRST + np.flatnonzero(np.isfinite(angles))[0]] = True
    held[FIRST:] |= not settings.free_angles
    return np.asarray(held)


def _solve(system: _System, angles: Array, settings: LoopSettings, check: SelfCheck) -> Array:
    """Gauss-Newton step (17 + n,).

    Wrong pairs must not drive the camera beyond what its file can be wrong by. What would go there stops at the limit,
    and the rest is solved again for that: axis and angles must fit the camera that is used.
    """
    free = ~_held(system, angles, settings)
    step = np.zeros(len(system.g))
    lowest, highest = np.full((2, len(step)), np.inf) * [[-1], [1]]
    lowest[SHARED:FIRST] = -MOST * check.prior - check.values
    highest[SHARED:FIRST] = MOST * check.prior - check.values
    for _ in NAMES:
        H, g = system.H[np.ix_(free, free)], system.g[free] + system.H[np.ix_(free, ~free)] @ step[~free]
        H = H + np.diag(np.diag(H) * 1e-6)
        scale = np.sqrt(np.diag(H))
        step[free] = solve(H / np.outer(scale, scale), -g / scale, assume_a="pos") / scale
        beyond = free & ((step < lowest) | (step > highest))
        if not beyond.any():
            break
        step = np.clip(step, lowest, highest)
        free &= ~beyond
    # far jumps come from wrong pairs: take them in parts
    rigid = np.delete(step, np.arange(SHARED, FIRST))
    return step * min(1.0, 0.1 / max(float(np.abs(rigid).max()), 1e-12))


def _wrap(angle: Array) -> Array:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)
