"""From what pairs of views say of small motions to normal equations of axis, focal length and views."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.axis import Axis
from fusion.turntable.pairs.pairwise import Twists

Array = NDArray[np.float64]
SHARED = 5  # tilt (2) and shift (2) of the axis, focal length


def planar_columns(axis: Axis) -> Array:
    """(6, 3) twists of a turn about the axis and shifts across it."""
    own = np.zeros((6, 3))
    own[:3, 0], own[3:, 1:] = axis.direction, axis.across().T
    return own


def normal_equations(
    found: Twists, axis: Axis, M: Array, edges: tuple[NDArray[np.intp], NDArray[np.intp]], weight: Array
) -> tuple[Array, Array]:
    """Matrix (k, k) and slope (k,), k = SHARED + 3 n, in [axis, focal length, (turn, shift 2) of each view].

    Args:
        found: of m edges.
        axis: of the table.
        M: (n, 4, 4) where the object is in each view.
        edges: source and model views (m,), (m,).
        weight: (m,) of the edges; 0 leaves one out.
    """
    i, j = edges
    own = planar_columns(axis)
    lean = np.zeros((6, 4))
    lean[:3, :2], lean[3:, 2:] = axis.across().T, axis.across().T
    shared = (np.eye(6) - adjoint(M, axis.point)) @ lean  # of each view
    between = adjoint(M[j] @ pose.inverse(M[i]), axis.point)
    k = SHARED + 3 * len(M)
    H, g = np.zeros((k, k)), np.zeros(k)
    J = np.zeros((7, SHARED + 6))
    J[6, SHARED - 1] = 1.0
    J[:6, SHARED : SHARED + 3] = own
    for e in np.flatnonzero(weight > 0):
        J[:6, : SHARED - 1] = shared[j[e]] - between[e] @ shared[i[e]]
        J[:6, SHARED + 3 :] = -between[e] @ own
        first, second = SHARED + 3 * j[e], SHARED + 3 * i[e]
        columns = np.r_[0:SHARED, first : first + 3, second : second + 3]
        H[np.ix_(columns, columns)] += weight[e] * J.T @ found.H[e] @ J
        g[columns] += weight[e] * J.T @ found.g[e]
    return H, g


def adjoint(T: Array, centre: Array) -> Array:
    """(m, 6, 6) that carries twists about a centre (3,), rotation first, through poses (m, 4, 4)."""
    R = T[:, :3, :3]
    moved = R @ centre + T[:, :3, 3] - centre  # of the centre
    out = np.zeros((len(T), 6, 6))
    out[:, :3, :3] = out[:, 3:, 3:] = R
    cross = np.zeros((len(T), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -moved[:, 2], moved[:, 1], -moved[:, 0]
    cross -= cross.swapaxes(1, 2)
    out[:, 3:, :3] = cross @ R
    return out


def planar(axis: Axis, turns: Array, shifts: Array) -> Array:
    """(n, 4, 4) turns (n,) about the axis, then shifts (n, 2) across it."""
    T = axis.turns(turns)
    T[:, :3, 3] += shifts @ axis.across()
    return np.asarray(T)
