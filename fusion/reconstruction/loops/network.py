"""The network of a walk's key frames: what pairs of them say of each other, the poses that suit it, their spread.

As in surveying: pairs say how far the poses may be off, and contradict each other by how much they are to be believed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.looks import Looks
from fusion.geometry.pose import Array, inverse, transform
from fusion.reconstruction.loops.edges import CLOSE, FIXED, landmark_edge, surface_edge, tracked_edge, within_fixed
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.reconstruction.loops.overlap import overlaps
from fusion.tracking.graph import BELIEVED, LOOSE, Edge, held, linear, normal, settle, vectors

ENOUGH = 0.35  # of the points that two views share, to be held against each other
PARTNERS = 3  # earlier ones for each key frame: those that are farthest back and share enough, and the last
MODES = 0.99  # of the variance of all poses is in the few largest patterns that are kept
FEW = 0.5  # edges of a kind for each key frame: fewer do not tell how good they are (guess)
ROUNDS = 4  # in which variance factors settle
WEIGHED = 2  # times: how far edges of a kind miss each other is known where they have settled
LEAST = 1e-6  # of the stated variance: less is never claimed


def spread_of(poses: Array, edges: Sequence[Edge]) -> Array:
    """Covariance (6 n, 6 n) of world twists of poses (n, 4, 4), as edges bear it out; the first is fixed.

    Where all edges together would have the poses elsewhere, that counts as one more error.
    """
    believed, spread = weighed(poses, edges)
    apart = settle(poses, believed).poses @ inverse(poses)
    elsewhere = np.concatenate([vectors(apart[:, :3, :3]), apart[:, :3, 3]], axis=1).ravel()
    return np.asarray(spread + np.outer(elsewhere, elsewhere))


def weighed(poses: Array, edges: Sequence[Edge], least: float = LEAST) -> tuple[list[Edge], Array]:
    """The edges with the information that they bear out at poses (n, 4, 4), and the covariance that this leaves.

    What an edge states of itself is a guess for its kind; how far edges of a kind miss each other tells their variance
    factor (Förstner 1979: variance components). Edges without a kind keep what they state.

    Args:
        least: of the stated variance, below which a factor never goes.
    """
    A, gaps = linear(poses, edges)
    stated = np.stack([e.information for e in edges])
    squares = np.einsum("mi,mij,mj->m", gaps, stated, gaps)
    slight = LOOSE * np.trace(stated, axis1=1, axis2=2)[:, None]
    ranks = np.maximum((np.linalg.eigvalsh(stated) > slight).sum(axis=1), 1)
    kinds = np.array([e.kind for e in edges])
    owners = [kinds == kind for kind in np.unique(kinds[kinds != ""])]
    fixed = (6 * held(len(poses), edges)[:, None] + np.arange(6)).ravel()
    free = np.setdiff1d(np.arange(6 * len(poses)), fixed)
    out, factor = np.zeros((6 * len(poses),) * 2), np.ones(len(edges))
    for own in owners:  # to begin with, and to tell which are wrong altogether
        factor[own] = max(float(np.median(squares[own] / ranks[own])), least)
    for _ in range(ROUNDS):
        weights = (BELIEVED / (BELIEVED + squares / factor)) ** 2
        information = (weights / factor)[:, None, None] * stated
        out[np.ix_(free, free)] = np.linalg.inv(normal(len(poses), edges, A, information)[free][:, free].toarray())
        taken = np.einsum("mij,mji->m", information, _between(out, A, edges))
        for own in owners:
            checked = float((weights * ranks)[own].sum() - taken[own].sum())
            factor[own] = max(float((weights * squares)[own].sum()) / checked, least) if checked > 1 else 1.0
    return [replace(e, information=e.information / by) for e, by in zip(edges, factor, strict=True)], out


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


@dataclass(frozen=True)
class PoseNetwork:
    """Key frames, and what those that have a place say of each other.

    Attributes:
        index: (m,) of those, among the key frames.
        frames: (m) themselves.
        edges: between them.
        poses: (k, 4, 4) of all key frames, NaN without a place, that suit the edges best; the first stays where it was.
    """

    index: NDArray[np.int64]
    frames: Sequence[Keyframe]
    edges: Sequence[Edge]
    poses: Array

    def moved(self, poses: Array) -> float:
        """How far [m] it moves the middle of what a key frame shows, at most, from poses (k, 4, 4)."""
        ends = zip(poses[self.index], self.poses[self.index], self.frames, strict=True)
        ways = (transform(T, f.points.centre) - transform(to, f.points.centre) for T, to, f in ends)
        return float(max(np.linalg.norm(way) for way in ways))

    def missed(self, kind: str) -> float:
        """Squares by which edges of a kind miss all others, over what they state; NaN where they are few."""
        own = [k for k, edge in enumerate(self.edges) if edge.kind == kind]
        if len(own) <= FEW * len(self.frames):
            return float("nan")
        believed = weighed(self.poses[self.index], self.edges)[0][own[0]]  # one factor for all of a kind
        return float(np.trace(self.edges[own[0]].information) / np.trace(believed.information))

    def known(self) -> NDArray[np.bool_]:
        """(m,) those of which it is known where they stand, seen from the one before, as well as an edge fixes it."""
        poses = self.poses[self.index]
        steps = inverse(poses[:-1]) @ poses[1:]
        middles = [transform(T, frame.points.centre) for T, frame in zip(steps, self.frames[1:], strict=True)]
        ways = [Edge(k, k + 1, T, np.eye(6), c) for k, (T, c) in enumerate(zip(steps, middles, strict=True))]
        # surfaces that slid together agree well: what edges state is not believed to be better than that
        spread = _between(weighed(poses, self.edges, least=1.0)[1], linear(poses, ways)[0], ways)
        return np.append(True, within_fixed(spread))

    def errors(self, poses: Array) -> PoseErrors:
        """What poses (n, 4, 4) of all frames of the recording may be wrong by together."""
        index = np.array([frame.index for frame in self.frames])
        values, vectors = np.linalg.eigh(spread_of(poses[index], self.edges))
        order = np.argsort(values)[::-1]
        values, vectors = np.maximum(values[order], 0), vectors[:, order]
        some = int(np.searchsorted(np.cumsum(values), MODES * values.sum())) + 1
        modes = vectors[:, :some] * np.sqrt(values[:some])
        return PoseErrors(index, modes.reshape(len(index), 6, -1), poses)


def pose_network(frames: Sequence[Keyframe], poses: Array) -> PoseNetwork | None:
    """From key frames at poses (k, 4, 4), NaN for those that have none; None with fewer than two that have one."""
    index = np.flatnonzero(np.isfinite(poses).all(axis=(1, 2)))
    if len(index) < 2:
        return None
    some = [frames[int(k)] for k in index]
    edges = _edges(some, poses[index])
    settled = np.array(poses)
    for _ in range(WEIGHED):
        settled[index] = settle(settled[index], weighed(settled[index], edges)[0]).poses
    return PoseNetwork(index, some, edges, settled)


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
            edges += [edge for edge in (surface and _firm(surface), marks) if edge is not None]
    return edges


def _firm(edge: Edge) -> Edge:
    """An edge by surfaces with less information where it slides.

    Noise averages over a surface, by an information l as 1 / l; errors that do not average, as a bent depth, make it
    slide along weak relief, as 1 / l^2. Both are equal where an edge is known to `FIXED`.
    """
    unit = np.repeat(FIXED[::-1], 3)
    values, vectors = np.linalg.eigh(unit[:, None] * edge.information * unit)
    values = np.maximum(values, 0)
    axes = vectors / unit[:, None]
    return replace(edge, information=(axes * values**2 / (values + 1)) @ axes.T)
