"""How well the poses of a walk are known: what pairs of its key frames say of each other, and what that leaves open.

The pairs make a network, as in surveying: they say how far the poses may be off, and contradict each other by how much
they are to be believed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.looks import Looks
from fusion.geometry.pose import Array, inverse
from fusion.reconstruction.loops.edges import CLOSE, landmark_edge, surface_edge, tracked_edge
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.reconstruction.loops.overlap import overlaps
from fusion.tracking.graph import BELIEVED, LOOSE, Edge, held, linear, normal, settle, vectors

ENOUGH = 0.35  # of the points that two views share, to be held against each other
PARTNERS = 3  # earlier ones for each key frame: those that are farthest back and share enough, and the last
MODES = 0.99  # of the variance of all poses is in the few largest patterns that are kept
ROUNDS = 4  # in which variance factors settle
LEAST = 1e-6  # of the stated variance: less is never claimed


def spread_of(poses: Array, edges: Sequence[Edge]) -> Array:
    """Covariance (6 n, 6 n) of world twists of poses (n, 4, 4), as edges bear it out; the first is fixed.

    What an edge states of itself is a guess for its kind; how far edges of a kind miss each other tells their variance
    factor (Förstner 1979: variance components). Edges without a kind keep what they state. Where all edges together
    would have the poses elsewhere, that counts as one more error.
    """
    A, gaps = linear(poses, edges)
    stated = np.stack([e.information for e in edges])
    squares = np.einsum("mi,mij,mj->m", gaps, stated, gaps)
    least = LOOSE * np.trace(stated, axis1=1, axis2=2)[:, None]
    ranks = np.maximum((np.linalg.eigvalsh(stated) > least).sum(axis=1), 1)
    kinds = np.array([e.kind for e in edges])
    owners = [kinds == kind for kind in np.unique(kinds[kinds != ""])]
    fixed = (6 * held(len(poses), edges)[:, None] + np.arange(6)).ravel()
    free = np.setdiff1d(np.arange(6 * len(poses)), fixed)
    out, factor = np.zeros((6 * len(poses),) * 2), np.ones(len(edges))
    for own in owners:  # to begin with, and to tell which are wrong altogether
        factor[own] = max(float(np.median(squares[own] / ranks[own])), LEAST)
    for _ in range(ROUNDS):
        weights = (BELIEVED / (BELIEVED + squares / factor)) ** 2
        information = (weights / factor)[:, None, None] * stated
        out[np.ix_(free, free)] = np.linalg.inv(normal(len(poses), edges, A, information)[free][:, free].toarray())
        taken = np.einsum("mij,mji->m", information, _between(out, A, edges))
        for own in owners:
            checked = float((weights * ranks)[own].sum() - taken[own].sum())
            factor[own] = max(float((weights * squares)[own].sum()) / checked, LEAST) if checked > 1 else 1.0
    believed = [replace(e, information=e.information / by) for e, by in zip(edges, factor, strict=True)]
    apart = settle(poses, believed).poses @ inverse(poses)
    elsewhere = np.concatenate([vectors(apart[:, :3, :3]), apart[:, :3, 3]], axis=1).ravel()
    return np.asarray(out + np.outer(elsewhere, elsewhere))


def _between(covariance: Array, A: Array, edges: Sequence[Edge]) -> Array:
    """(m, 6, 6) covariance of where each edge's j stands as seen from i."""
    i, j = (np.array([getattr(edge, end) for edge in edges]) for end in "ij")
    blocks = covariance.reshape(len(covariance) // 6, 6, -1, 6).swapaxes(1, 2)
    apart = blocks[i, i] + blocks[j, j] - blocks[i, j] - blocks[j, i]
    return np.asarray(A @ apart @ A.swapaxes(1, 2))


@dataclass(frozen=True)
class PoseErrors:
    """What all poses of a walk may be wrong by together."""

    index: NDArray[np.int64]  # (k,) frames of the recording that were key frames
    modes: Array  # (k, 6, r) world twists [rad], [m]: independent patterns, each one standard deviation
    poses: Array  # (n, 4, 4) of all frames, NaN where lost

    def along(self, points: Array, normals: Array, looks: Looks) -> Array:
        """Standard deviation (m,) [m] along normals (m, 3) of points (m, 3), once the whole is laid on the truth."""
        lever = np.hstack([np.cross(points, normals), normals])  # (m, 6): what a world twist moves along the normal
        frames = [int(np.flatnonzero((self.poses == T).all(axis=(1, 2)))[0]) for T in looks.poses]
        each = np.stack([np.interp(frames, self.index, np.eye(len(self.index))[k]) for k in range(len(self.index))])
        weight = looks.share().astype(float) @ each.T
        moved = np.zeros((len(points), self.modes.shape[2]))
        for axis in range(6):
            moved += lever[:, axis, None] * (weight @ self.modes[:, axis])
        rigid = np.linalg.lstsq(lever, moved, rcond=None)[0]
        return np.asarray(np.sqrt(np.sum((moved - lever @ rigid) ** 2, axis=1)))


def pose_errors(frames: Sequence[Keyframe], poses: Array) -> PoseErrors | None:
    """From key frames and the poses (n, 4, 4) of all frames; None with fewer than two placed key frames."""
    known = [frame for frame in frames if np.isfinite(poses[frame.index]).all()]
    if len(known) < 2:
        return None
    index = np.array([frame.index for frame in known])
    T = poses[index]
    values, vectors = np.linalg.eigh(spread_of(T, _edges(known, T)))
    order = np.argsort(values)[::-1]
    values, vectors = np.maximum(values[order], 0), vectors[:, order]
    some = int(np.searchsorted(np.cumsum(values), MODES * values.sum())) + 1
    modes = vectors[:, :some] * np.sqrt(values[:some])
    return PoseErrors(index, modes.reshape(len(known), 6, -1), poses)


def _edges(frames: Sequence[Keyframe], poses: Array) -> list[Edge]:
    """What each key frame and some before it say of each other at their poses (k, 4, 4)."""
    placed = [replace(frame, T_world_camera=T, piece=0) for frame, T in zip(frames, poses, strict=True)]
    shares, edges = overlaps(placed, poses), list[Edge]()
    for j in range(1, len(placed)):
        edges.append(replace(tracked_edge(placed, j - 1, j), kind=""))  # of these poses: they do not check it
        before = np.flatnonzero(shares[j, :j] > ENOUGH)
        spread = before[np.linspace(0, max(len(before) - 1, 0), min(PARTNERS, len(before))).round().astype(int)]
        for i in {j - 1, *spread.tolist()}:
            surface = surface_edge(placed, (i, j), inverse(poses[i]) @ poses[j], CLOSE, doubtful=True)
            marks = landmark_edge(placed, i, j, doubtful=True)
            edges += [edge for edge in (surface, marks) if edge is not None]
    return edges
