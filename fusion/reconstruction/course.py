"""The course of the camera: pieces joined, loops closed, all key frames settled together, or what drift is known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array, inverse
from fusion.reconstruction.loops.between import Between
from fusion.reconstruction.loops.closing import ClosedLoops, close, looked_away
from fusion.reconstruction.loops.correction import corrected
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.reconstruction.loops.network import PoseNetwork, pose_network
from fusion.results.course import Course
from fusion.tracking.tracker import Tracked

# of the squares by which landmarks state they may miss: a cautious statement, as simulated rooms reached 0.04 to 0.2 of
# what they may miss, colours one frame late 0.5, mirrored ones 26 times
MISSED = 1.0
SLID = 0.05  # of the frames: good for the light on directions up to 0.1 (guess)


@dataclass(frozen=True)
class Straightened:
    """What became of a trajectory."""

    results: list[Tracked]  # (n) of the frames
    course: Course | None = None  # how it hangs together; None where poses were given
    # the key frames where they belong now; None where nothing has changed since the frames were fused
    between: Between | None = None
    network: PoseNetwork | None = None  # of the key frames that have a place; None where there are fewer than two
    known: frozenset[int] = frozenset()  # see `Reconstruction`
    colors_missed: float | None = None  # see `PoseNetwork.missed`, of landmarks that were left out for it


def straighten(
    results: list[Tracked],
    pieces: NDArray[np.int64],
    stamps: NDArray[np.float64],
    frames: Sequence[Keyframe],
    resolved: float,
) -> Straightened:
    """Join pieces, close loops, and settle what is left by the network of all key frames.

    Colours whose landmarks contradict everything else are left out.

    Args:
        results: (n) as tracked; poses of different pieces have nothing to do with each other.
        pieces: (n,) of the trajectory.
        stamps: (n,) time [s].
        resolved: motion [m] that what is fused can show: smaller ones are let be.
    """
    count = len({frame.piece for frame in frames})
    if not count:  # nothing was placed
        return Straightened(results, Course(0.0, True, 0, 0))
    tracked = np.stack([frame.T_world_camera for frame in frames])
    away = looked_away(frames, tracked)
    # where a surface slides along itself, the poses do not tell whether the camera looked away
    slid = float(np.mean([bool(result.unconstrained) for result in results])) > SLID
    closed = close(frames) if away or slid or count > 1 else None
    settled = _largest(frames, results, pieces) if closed is None else closed.poses
    network = pose_network(frames, settled)
    missed = float("nan") if network is None else network.missed("landmarks")
    if missed > MISSED:
        blind = [replace(frame, grey=None) for frame in frames]
        return replace(straighten(results, pieces, stamps, blind, resolved), colors_missed=missed)
    if network is not None and network.moved(settled) > resolved:
        settled = network.poses
    elif closed is None and count == 1:
        course = Course(_path(frames, tracked), not away, 1, 1)
        return Straightened(results, course, network=network, known=_known(network, len(results)))
    before = np.stack([r.T_world_camera for r in results])
    found = corrected(before, pieces, stamps, frames, settled)
    poses = found.poses
    known = np.isfinite(poses).all(axis=(1, 2))
    world = inverse(poses[np.flatnonzero(known)[0]])  # the world is the first placed frame
    poses = world @ poses
    moved = [_with(r, T) for r, T in zip(results, poses, strict=True)]
    joined = len(np.unique(pieces[known]))
    path = _path(frames, settled)
    away = looked_away(frames, np.where(np.isfinite(settled), settled, tracked))
    course = _course(path, away, (count, joined), closed, before, poses)
    between = Between(frames, world @ settled, found.off, found.torn)
    return Straightened(moved, course, between, network, known=_known(network, len(results)))


def _course(
    path: float, away: bool, pieces: tuple[int, int], closed: ClosedLoops | None, before: Array, poses: Array
) -> Course:
    known = np.isfinite(poses).all(axis=(1, 2))
    moved = float(np.linalg.norm((before - poses)[known, :3, 3], axis=1).max())
    if closed is None:
        return Course(path, not away, *pieces)
    return Course(
        path, not away, *pieces, len(closed.met), closed.refused, closed.before, closed.after, moved,
    )  # fmt: skip


def _with(result: Tracked, T_world_camera: Array) -> Tracked:
    if not result.ok:
        return result
    if np.isfinite(T_world_camera).all():
        return replace(result, T_world_camera=T_world_camera)
    status = "placed only among frames after a loss, which show nothing that the others show"
    return replace(result, T_world_camera=T_world_camera, status=status)


def _known(network: PoseNetwork | None, count: int) -> frozenset[int]:
    """Those of so many frames before which and after which the key frames know where they stand to each other."""
    if network is None:
        return frozenset()
    index, known = np.array([frame.index for frame in network.frames]), network.known()
    after = np.minimum(np.searchsorted(index, np.arange(count)), len(index) - 1)  # behind the last as before it
    return frozenset(np.flatnonzero(known[after]).tolist())


def _largest(frames: Sequence[Keyframe], results: Sequence[Tracked], pieces: NDArray[np.int64]) -> Array:
    """Poses of the key frames of the piece with most frames, as they are; NaN for the others."""
    main = np.bincount(pieces[[r.ok for r in results]]).argmax()
    poses = np.stack([frame.T_world_camera for frame in frames])
    poses[[frame.piece != main for frame in frames]] = np.nan
    return poses


def _path(frames: Sequence[Keyframe], poses: Array) -> float:
    """Length of the way within pieces [m], from key frame to key frame, where they have a pose (k, 4, 4)."""
    steps = [j for j in range(1, len(frames)) if frames[j].piece == frames[j - 1].piece]
    ways = [np.linalg.norm(poses[j, :3, 3] - poses[j - 1, :3, 3]) for j in steps]
    return float(np.nansum(ways))
