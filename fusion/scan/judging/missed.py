"""By how much two views miss each other where a motion puts them: aligned directly, with no model and no axis between.

Two views slide along surfaces that look the same there, so a distance alone says little: what counts is how much worse
the motion fits the two than they fit each other.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.geometry import pose
from fusion.geometry.robust import EFFECTIVE, SURE
from fusion.geometry.trajectory import Trajectory
from fusion.results.facts import Gap
from fusion.scan.finding.poses import TRACKING, only
from fusion.tracking.equations import lay_out
from fusion.tracking.icp import IcpResult, align
from fusion.turntable.jumps import Jump
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
OTHERS = 12  # pairs whose median tells what views of this scan miss each other by: to a fifth of itself
SHARPEST = 0.1  # of what noise lets expect: less is the rounding of depth that has none


def aligned(
    frames: list[Prepared | None], region: Region, guess: Trajectory, pair: tuple[int, int]
) -> IcpResult | None:
    """Two frames aligned from where a trajectory puts them; None where one has no place, or they do not fit."""
    first, second = frames[pair[0]], frames[pair[1]]
    if first is None or second is None or not np.isfinite(guess.poses[list(pair)]).all():
        return None
    T = pose.inverse(guess.poses[pair[0]]) @ guess.poses[pair[1]]
    found = align(only(second.surface, region), first.surface, T, TRACKING)
    return found if found.ok else None


def gap_of(
    frames: list[Prepared | None], region: Region, trajectory: Trajectory, pair: tuple[int, int], direct: IcpResult
) -> Gap | None:
    """How far a trajectory is from a pair that was aligned directly; None where it has no place for one of them."""
    i, j = trajectory.poses[list(pair)]
    second = frames[pair[1]]
    if second is None or not (np.isfinite(i).all() and np.isfinite(j).all()):
        return None
    T = pose.inverse(i) @ j
    middle = (region.low + region.high) / 2
    shift = pose.transform(T, middle) - pose.transform(direct.T_model_source, middle)
    centre = lay_out(only(second.surface, region), TRACKING.points[-1]).centre
    about, moved = (pose.transform(at, centre) for at in (direct.T_model_source, T))
    turn = Rotation.from_matrix(T[:3, :3] @ direct.T_model_source[:3, :3].T).as_rotvec()
    twist = np.concatenate([turn, moved - about])
    deviations = float(np.sqrt(EFFECTIVE * twist @ direct.information @ twist))
    return Gap(pose.angle(pose.inverse(direct.T_model_source) @ T), float(np.linalg.norm(shift)), deviations)


def closing_gaps(
    frames: list[Prepared | None], region: Region, trajectories: tuple[Trajectory, Trajectory], angles: Array
) -> tuple[Gap | None, Gap | None]:
    """Where a turn closes: by how much two trajectories, after and before the fit, miss two views about a turn apart.

    The deviations are those of other views, between which no turn lies: errors of depth that stand still in the image,
    of which no noise tells, make them miss each other by more, and noise that neighbours do not share by less. None
    without a full turn.
    """
    pair = closing_pair(angles)
    direct = None if pair is None else aligned(frames, region, trajectories[0], pair)
    if pair is None or direct is None:
        return None, None
    others = []
    for other in _as_far_apart(angles, pair):
        found = aligned(frames, region, trajectories[0], other)
        gap = None if found is None else gap_of(frames, region, trajectories[0], other, found)
        others += [] if gap is None else [gap.deviations]
    usual = max(float(np.median(others)), SHARPEST) if others else 1.0
    gaps = [gap_of(frames, region, t, pair, direct) for t in trajectories]
    after, before = (None if g is None else replace(g, deviations=g.deviations / usual) for g in gaps)
    return after, before


def _as_far_apart(angles: Array, pair: tuple[int, int]) -> list[tuple[int, int]]:
    """Some pairs of frames with about the same turn between them as these two have but for whole turns."""
    i, j = np.triu_indices(len(angles), 1)
    turn = np.abs(angles[j] - angles[i])
    known = turn < np.pi  # of NaN it is not true
    i, j, turn = i[known], j[known], turn[known]
    rest = np.abs((angles[pair[1]] - angles[pair[0]] + np.pi) % (2 * np.pi) - np.pi)
    near = np.sort(np.argsort(np.abs(turn - rest), kind="stable")[: 4 * OTHERS])[::4]
    return [(int(i[k]), int(j[k])) for k in near]


def confirmed(jump: Jump | None, frames: list[Prepared | None], region: Region, by_axis: Trajectory) -> Jump | None:
    """The jump, if frames before and after it show it too when they are aligned directly; its distance from them.

    Free tracking may lose its way where nothing moved; two views aligned from where the axis puts them do not.
    """
    if jump is None:
        return None
    pairs = [(jump.frame - 1 - a, jump.frame + b) for a, b in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 2))]
    gaps = []
    for pair in pairs:
        inside = pair[0] >= 0 and pair[1] < len(frames)
        found = aligned(frames, region, by_axis, pair) if inside else None
        gap = None if found is None else gap_of(frames, region, by_axis, pair, found)
        gaps += [] if gap is None else [(gap.distance, gap.deviations)]
    if not gaps:
        return None
    distance, deviations = np.median(gaps, axis=0)
    real = distance > jump.distance / 2 and deviations > SURE
    return replace(jump, distance=float(distance)) if real else None


def closing_pair(angles: Array) -> tuple[int, int] | None:
    """Two frames (i, j) about a full turn apart, the nearest views of the two ends; None without such a pair."""
    known = np.flatnonzero(np.isfinite(angles))
    i, j = np.triu_indices(len(known), 1)
    i, j = known[i], known[j]
    turn = np.abs(angles[j] - angles[i])
    rest = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    fit = (turn > np.pi) & (rest < np.deg2rad(50))
    if not fit.any():
        return None
    best = int(np.argmin(np.where(fit, rest - 1e-3 * (j - i), np.inf)))
    return int(i[best]), int(j[best])
