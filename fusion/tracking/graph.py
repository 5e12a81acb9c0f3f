"""A pose graph: nodes are poses, edges say where one lies as seen from another, and how well each direction is known.

An edge's information may leave directions open (a plane does not say where along itself a camera stands). Edges that
close a loop may be wrong; they are held against all others by graduated non-convexity (Yang, Antonante, Tzoumas and
Carlone 2020, eq. 11 to 14, for the loss of Geman and McClure).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Array = NDArray[np.float64]

ITERATIONS = 60
SETTLED = 1e-5  # [rad], [m]
# squared error, in variances, up to which a doubtful edge is believed: six directions at four standard deviations
BELIEVED = 6 * 4.0**2
EASED = 1.4  # by which the loss comes nearer to its final form in each iteration (the paper's)
TURN = 0.5  # [rad] largest turn of a step: linear steps hold for small ones, and loose poses would fly off (guess)
LOOSE = 1e-6  # of the largest information: keeps what no edge fixes where it is


@dataclass(frozen=True)
class Edge:
    """What is known of a pose as seen from another."""

    # i, j: nodes
    i: int
    j: int
    T_i_j: Array  # (4, 4) as measured
    information: Array  # (6, 6) inverse covariance of a left twist of it, turns about `centre`: [rad], [m]
    centre: Array  # (3,) in the frame of i [m]
    doubtful: bool = False  # it may be wrong altogether
    kind: str = ""  # what says so, in a word
    share: float = float("nan")  # of what both show that fits, where that is known


@dataclass(frozen=True)
class Settled:
    """Poses that suit all edges."""

    poses: Array  # (n, 4, 4)
    weights: Array  # (m,) of the edges, 1 where they are believed and near 0 where the others contradict
    # (m,) square root of the mean squared error of each edge over its six directions, in standard deviations
    errors: Array


def settle(poses: Array, edges: Sequence[Edge]) -> Settled:
    """Poses (n, 4, 4) that suit the edges best; the first of each part that hangs together stays where it is."""
    T = np.array(poses, float)
    if not edges:
        return Settled(T, np.zeros(0), np.zeros(0))
    doubtful = np.array([edge.doubtful for edge in edges])
    fixed = held(len(T), edges)
    hardness = 0.0
    weights = np.ones(len(edges))
    for _ in range(ITERATIONS):
        H, gaps = linear(T, edges)
        squares = np.einsum("mi,mij,mj->m", gaps, np.stack([e.information for e in edges]), gaps)
        worst = float(squares[doubtful].max()) if doubtful.any() else 0.0
        hardness = max(2 * worst / BELIEVED, 1.0) if not hardness else max(hardness / EASED, 1.0)
        bound = hardness * BELIEVED
        weights = np.where(doubtful, (bound / (bound + squares)) ** 2, 1.0)
        steps = _step(len(T), edges, H, gaps, weights, fixed)
        T = _moved(T, steps)
        if hardness == 1.0 and np.abs(steps).max() < SETTLED:
            break
    _, gaps = linear(T, edges)
    squares = np.einsum("mi,mij,mj->m", gaps, np.stack([e.information for e in edges]), gaps)
    return Settled(T, weights, np.sqrt(squares / 6))


def parts(n: int, edges: Sequence[Edge]) -> NDArray[np.int64]:
    """For each of n nodes (n,) the smallest number of those that it hangs together with."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    i, j = (np.array([getattr(edge, end) for edge in edges], int) for end in "ij")
    _, label = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (n, n)), directed=False)
    first = np.full(label.max() + 1, n)
    np.minimum.at(first, label, np.arange(n))
    return np.asarray(first[label], np.int64)


def held(n: int, edges: Sequence[Edge]) -> NDArray[np.int64]:
    """The first of each part that hangs together: it stays where it is."""
    return np.unique(parts(n, edges))


def linear(T: Array, edges: Sequence[Edge]) -> tuple[Array, Array]:
    """Of each edge the change (m, 6, 6) of its twist with a world twist of j, and the twist (m, 6) that it misses."""
    i, j = (np.array([getattr(edge, end) for edge in edges]) for end in "ij")
    measured, centre = np.stack([e.T_i_j for e in edges]), np.stack([e.centre for e in edges])
    D = measured @ pose.inverse(pose.inverse(T[i]) @ T[j])
    gaps = np.concatenate([vectors(D[:, :3, :3]), _transformed(D, centre) - centre], axis=1)
    R = np.swapaxes(T[i][:, :3, :3], 1, 2)
    c = _transformed(T[i], centre)
    zero = np.zeros(len(edges))
    cross = np.array([[zero, -c[:, 2], c[:, 1]], [c[:, 2], zero, -c[:, 0]], [-c[:, 1], c[:, 0], zero]])
    A = np.zeros((len(edges), 6, 6))
    A[:, :3, :3] = A[:, 3:, 3:] = R
    A[:, 3:, :3] = -R @ np.moveaxis(cross, 2, 0)
    return A, gaps


def normal(n: int, edges: Sequence[Edge], A: Array, weighted: Array) -> "csr_matrix":
    """Normal matrix (6 n, 6 n) of the nodes' world twists."""
    from scipy.sparse import coo_matrix

    i, j = (np.array([getattr(edge, end) for edge in edges]) for end in "ij")
    H = np.swapaxes(A, 1, 2) @ weighted @ A
    blocks = [(i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)]
    down, across = np.mgrid[0:6, 0:6]
    rows = np.concatenate([(6 * a[:, None, None] + down).ravel() for a, _, _ in blocks])
    columns = np.concatenate([(6 * b[:, None, None] + across).ravel() for _, b, _ in blocks])
    values = np.concatenate([(sign * H).ravel() for _, _, sign in blocks])
    return coo_matrix((values, (rows, columns)), (6 * n, 6 * n)).tocsr()


def _step(
    n: int, edges: Sequence[Edge], A: Array, gaps: Array, weights: Array, fixed: NDArray[np.int64]
) -> Array:  # fmt: skip
    """Gauss-Newton step (n, 6) of the nodes' world twists."""
    from scipy.sparse import identity
    from scipy.sparse.linalg import spsolve

    i, j = (np.array([getattr(edge, end) for edge in edges]) for end in "ij")
    weighted = weights[:, None, None] * np.stack([e.information for e in edges])
    b = np.einsum("mki,mkl,ml->mi", A, weighted, gaps)
    rhs = np.zeros((n, 6))
    np.add.at(rhs, j, b)
    np.add.at(rhs, i, -b)
    system = normal(n, edges, A, weighted)
    free = np.setdiff1d(np.arange(6 * n), (6 * fixed[:, None] + np.arange(6)).ravel())
    if not len(free):
        return np.zeros((n, 6))
    inner = system[free][:, free]
    step = np.zeros(6 * n)
    step[free] = spsolve(
        (inner + LOOSE * float(inner.diagonal().mean()) * identity(len(free))).tocsc(), rhs.ravel()[free]
    )
    steps = step.reshape(n, 6)
    turn = float(np.linalg.norm(steps[:, :3], axis=1).max())
    return np.asarray(steps * (TURN / max(turn, TURN)))


def _moved(T: Array, twists: Array) -> Array:
    """Poses (n, 4, 4) after world twists (n, 6)."""
    R = pose.rotation(twists[:, :3])
    out = T.copy()
    out[:, :3, :3] = R @ T[:, :3, :3]
    out[:, :3, 3] = np.einsum("nij,nj->ni", R, T[:, :3, 3]) + twists[:, 3:]
    return out


def vectors(R: Array) -> Array:
    """Rotation vectors (m, 3) [rad] of matrices (m, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(R).as_rotvec())


def _transformed(T: Array, points: Array) -> Array:
    """Points (m, 3), each by its own pose (m, 4, 4)."""
    return np.asarray(np.einsum("mij,mj->mi", T[:, :3, :3], points) + T[:, :3, 3])
