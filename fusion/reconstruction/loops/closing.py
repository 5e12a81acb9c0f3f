"""Close the loops: find key frames that show the same place again, and poses that suit all that is known of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.progress import each
from fusion.reconstruction.loops.correction import TORN
from fusion.reconstruction.loops.edges import (
    CLOSE,
    MET,
    agree,
    fixed,
    landmark_edge,
    seen_edge,
    surface_edge,
    tracked_edge,
)  # fmt: skip
from fusion.reconstruction.loops.keyframes import Keyframe, sighted, surroundings
from fusion.reconstruction.loops.overlap import APART, left_and_met, overlaps
from fusion.tracking.graph import Edge, Settled, parts, settle
from fusion.tracking.landmarks import Landmarks
from fusion.tracking.shapes import shape_landmarks

NEIGHBOURS = 2  # each key frame is held against so many before it
ENOUGH = 0.35  # of the points two views must share to be held against each other
PARTNERS = 4  # for each key frame, of those that met again
TRIES = 3 * PARTNERS  # to find them
LOOKED = 100  # key frames at most that are compared with all others by their landmarks, and every second at most
ROUNDS = 2  # of finding the same surface from better poses
WORST = 0.2  # of the way, that a camera drifts by (a simulated room with bare walls; furnished ones 0.003 to 0.03)
BESIDE = 3  # key frames
LIKE = 0.9  # of the share that fits between neighbours must fit where two views meet again (guess; wrong ones had 0.85)
FEWEST = 2  # pairs of key frames that join two pieces: one alone may be chance


@dataclass(frozen=True)
class ClosedLoops:
    """Key frames in their places."""

    poses: Array  # (k, 4, 4) `T_world_camera` of the key frames; NaN for those of pieces that met nothing
    met: tuple[tuple[int, int], ...]  # pairs of key frames that saw the same again and are believed
    refused: int  # number of pairs that the others contradict
    # before, after: rms over the pairs that met, of how far their surfaces were and are apart [m]
    before: float
    after: float


def looked_away(frames: Sequence[Keyframe], poses: Array) -> bool:
    """The camera looked away from something that it saw, as poses (k, 4, 4) have it: then it may meet that again."""
    shares = overlaps(frames, poses)
    return any((shares[k] < APART)[[f.piece == frame.piece for f in frames]].any() for k, frame in enumerate(frames))


def close(frames: Sequence[Keyframe]) -> ClosedLoops | None:
    """The poses that suit everything; None where nothing was met again, and neighbours agree with the tracking."""
    poses = np.stack([frame.T_world_camera for frame in frames])
    chain = _chain(frames)
    contradicted = any(_contradicts(edge, poses) for edge in chain)
    if contradicted:
        poses = settle(poses, chain).poses
    met = _seen_again(frames, poses, overlaps(frames, poses), chain)
    if not met and not contradicted:
        return None
    poses, met = _joined(frames, poses, met)
    settled = settle(poses, chain + met)
    for _ in range(ROUNDS):
        met = _again(frames, settled, chain, met)
        settled = settle(settled.poses, chain + met)
    return _closed(frames, settled, chain, met)


def _contradicts(edge: Edge, poses: Array) -> bool:
    """Neighbours show that they were tracked wrongly; by landmarks, as tracking has seen the surfaces too."""
    if edge.kind != "landmarks":
        return False
    apart = inverse(edge.T_i_j) @ inverse(poses[edge.i]) @ poses[edge.j]
    return bool(np.linalg.norm(apart[:3, 3]) > TORN[0] or angle(apart) > TORN[1])


def _chain(frames: Sequence[Keyframe]) -> list[Edge]:
    """Edges between neighbours of a piece: as tracked, by surface, by landmarks."""
    edges = []
    for j in each(range(len(frames)), "neighbours"):
        for i in range(max(0, j - NEIGHBOURS), j):
            if frames[i].piece == frames[j].piece:
                edges += _neighbours(frames, i, j, inverse(frames[i].T_world_camera) @ frames[j].T_world_camera)
    return edges


def _neighbours(frames: Sequence[Keyframe], i: int, j: int, T_i_j: Array) -> list[Edge]:
    """Landmarks count where the surfaces bear them out, as the images may belong to another moment, and are sure where
    surfaces alone did not hold the camera on its way."""
    edges = [tracked_edge(frames, i, j)] if j == i + 1 else []
    seen, held = _verified(frames, i, j), all(frame.held for frame in frames[i + 1 : j + 1])
    if seen:
        return [*edges, *(replace(edge, doubtful=held) for edge in seen)]
    surface = surface_edge(frames, (i, j), T_i_j, CLOSE, doubtful=False)
    return edges if surface is None else [*edges, surface]


def _seen_again(frames: Sequence[Keyframe], poses: Array, shares: Array, chain: Sequence[Edge]) -> list[Edge]:
    """Edges between key frames that show the same after the camera was elsewhere, by their poses or by landmarks."""
    usual = LIKE * float(np.median([edge.share for edge in chain if edge.kind == "surface"] or [1.0]))
    edges = _by_poses(frames, poses, shares, usual)
    if _may_be_far(frames, poses):
        far = _unmet(_far_pairs(frames, shares), [edge for edge in edges if edge.kind == "landmarks" or fixed(edge)])
        if sighted(frames):
            edges += [edge for i, j in each(far, "recognising") for edge in _verified(frames, i, j)]
            edges += [edge for i, j in _beside_joints(frames, edges) for edge in _verified(frames, i, j)]
        else:
            edges += _by_shape(frames, poses, far, usual)
    convincing = any(edge.kind == "landmarks" or fixed(edge) for edge in edges)
    return edges if convincing else []


def _by_poses(frames: Sequence[Keyframe], poses: Array, shares: Array, share: float) -> list[Edge]:
    """Edges between key frames that met again as far as their poses tell."""
    edges: list[Edge] = []
    count, tries = np.zeros((2, len(frames)), int)
    for i, j in each(sorted(left_and_met(shares, ENOUGH), key=lambda pair: -shares[pair]), "meeting"):
        if max(count[i], count[j]) < PARTNERS and max(tries[i], tries[j]) < TRIES:
            tries[[i, j]] += 1
            found = _verified(frames, i, j)
            if not found:
                alone = surface_edge(frames, (i, j), inverse(poses[i]) @ poses[j], MET, True, share)
                found = [] if alone is None else [alone]
            count[[i, j]] += bool(found)
            edges += found
    return edges


def _may_be_far(frames: Sequence[Keyframe], poses: Array) -> bool:
    """The camera may have drifted farther than its poses help to find where it met what it had seen."""
    if len({frame.piece for frame in frames}) > 1:
        return True
    way = float(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum())
    return WORST * way > MET.reaches[0]


def _unmet(pairs: Sequence[tuple[int, int]], edges: Sequence[Edge]) -> list[tuple[int, int]]:
    """Pairs that are not beside one that has met already."""
    known = np.array([(edge.i, edge.j) for edge in edges]).reshape(-1, 2)
    return [pair for pair in pairs if not (np.abs(known - pair).max(axis=1, initial=0) <= BESIDE).any()]


def _far_pairs(frames: Sequence[Keyframe], shares: Array) -> list[tuple[int, int]]:
    """Pairs of key frames between which the camera looked elsewhere, spread where there are very many."""
    step = max(2, -(-len(frames) // LOOKED))
    some = range(0, len(frames), step)
    pairs = []
    for i in some:
        left = False
        for j in range(i + 1, len(frames)):
            left = left or shares[i, j] < APART
            if left and j in some:
                pairs.append((i, j))
    return pairs


def _beside_joints(frames: Sequence[Keyframe], edges: Sequence[Edge]) -> list[tuple[int, int]]:
    """Pairs beside those by which two pieces meet: not all pairs are looked at, and one alone joins nothing."""
    met = {(e.i, e.j) for e in edges if frames[e.i].piece != frames[e.j].piece}
    beside = {(i + a, j + b) for i, j in met for a in (-1, 0, 1) for b in (-1, 0, 1)} - met
    inside = [(i, j) for i, j in beside if min(i, j) >= 0 and max(i, j) < len(frames)]
    return sorted((i, j) for i, j in inside if frames[i].piece != frames[j].piece)


def _verified(frames: Sequence[Keyframe], i: int, j: int) -> list[Edge]:
    """What landmarks and surfaces of a pair say, when they agree."""
    marks = landmark_edge(frames, i, j, doubtful=True)
    surface = None if marks is None else surface_edge(frames, (i, j), marks.T_i_j, CLOSE, doubtful=True)
    return [] if marks is None or surface is None or not agree(marks, surface) else [marks, surface]


def _by_shape(frames: Sequence[Keyframe], poses: Array, pairs: Sequence[tuple[int, int]], share: float) -> list[Edge]:
    """Edges by landmarks of the surfaces around key frames, where there is no colour."""
    shown: dict[int, Landmarks] = {}
    for k in each(sorted({k for pair in pairs for k in pair}), "shapes"):
        shown[k] = shape_landmarks(*surroundings(frames, poses, k))
    edges = []
    for i, j in each(pairs, "recognising"):
        edge = seen_edge(frames, (i, j), (shown[i], shown[j]), share)
        if edge is not None and fixed(edge):
            edges.append(edge)
    return edges


def _joined(frames: Sequence[Keyframe], poses: Array, met: list[Edge]) -> tuple[Array, list[Edge]]:
    """Poses in which each piece stands as its best edge to the others says; pieces joined by too little stay apart."""
    poses = poses.copy()
    pieces = np.array([frame.piece for frame in frames])
    between: dict[tuple[int, int], list[Edge]] = {}
    for edge in met:
        a, b = pieces[edge.i], pieces[edge.j]
        if a != b:
            between.setdefault((min(a, b), max(a, b)), []).append(edge)
    weak = {pair for pair, edges in between.items() if len({(e.i, e.j) for e in edges}) < FEWEST}
    met = [e for e in met if (min(pieces[e.i], pieces[e.j]), max(pieces[e.i], pieces[e.j])) not in weak]
    sizes = np.bincount(pieces)
    placed = {int(np.argmax(sizes))}
    while True:
        ready = [e for e in met if (pieces[e.i] in placed) != (pieces[e.j] in placed)]
        if not ready:
            return poses, met
        best = max(ready, key=lambda e: float(np.trace(e.information)))
        inside = pieces[best.i] in placed
        new, T = (best.j, poses[best.i] @ best.T_i_j) if inside else (best.i, poses[best.j] @ inverse(best.T_i_j))
        moved = T @ inverse(poses[new])
        members = pieces == pieces[new]
        poses[members] = moved @ poses[members]
        placed.add(int(pieces[new]))


def _again(frames: Sequence[Keyframe], settled: Settled, chain: list[Edge], met: list[Edge]) -> list[Edge]:
    """Surfaces that meet at better poses, and the landmarks that were found before."""
    poses = settled.poses
    label = parts(len(frames), [*chain, *met])
    alike = [replace(frame, piece=int(label[k])) for k, frame in enumerate(frames)]
    marks = [edge for edge in met if edge.kind == "landmarks"]
    shares = overlaps(alike, poses)
    known = {(edge.i, edge.j): edge for edge in marks}
    edges, count = list(marks), np.zeros(len(frames), int)
    pairs = sorted(left_and_met(shares, ENOUGH), key=lambda pair: -shares[pair])
    for i, j in each(pairs, "meeting"):
        if max(count[i], count[j]) < PARTNERS:
            found = surface_edge(frames, (i, j), inverse(poses[i]) @ poses[j], CLOSE, doubtful=True)
            if found is None or ((i, j) in known and not agree(found, known[i, j])):
                continue
            count[[i, j]] += 1
            edges.append(found)
    return edges


def _closed(frames: Sequence[Keyframe], settled: Settled, chain: list[Edge], met: list[Edge]) -> ClosedLoops:
    edges = [*chain, *met]
    believed = settled.weights > 0.25
    good = [edge for edge, yes in zip(edges, believed, strict=True) if yes]
    label = parts(len(frames), good)
    main = np.bincount(label).argmax()
    poses = np.where((label == main)[:, None, None], settled.poses, np.nan)
    again = [edge for edge, yes in zip(met, believed[len(chain) :], strict=True) if yes]
    before = np.stack([frame.T_world_camera for frame in frames])
    return ClosedLoops(
        poses,
        tuple(sorted({(edge.i, edge.j) for edge in again})),
        len({(e.i, e.j) for e in met}) - len({(e.i, e.j) for e in again}),
        _apart(before, again, frames),
        _apart(settled.poses, again, frames),
    )


def _apart(poses: Array, edges: Sequence[Edge], frames: Sequence[Keyframe]) -> float:
    """Rms over edges within a piece of how far their centres miss each other [m]."""
    off = []
    for edge in edges:
        if frames[edge.i].piece == frames[edge.j].piece:
            missed = edge.T_i_j @ inverse(inverse(poses[edge.i]) @ poses[edge.j])
            off.append(np.linalg.norm(transform(missed, edge.centre) - edge.centre))
    return float(np.sqrt(np.mean(np.square(off)))) if off else float("nan")
