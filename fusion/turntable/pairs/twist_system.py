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
    told = np.flatnonzero(weight > 0)
    i, j, between = i[told], j[told], between[told]
    J = np.zeros((len(told), 7, SHARED + 6))
    J[:, 6, SHARED - 1] = 1.0
    J[:, :6, : SHARED - 1] = shared[j] - between @ shared[i]
    J[:, :6, SHARED : SHARED + 3] = own
    J[:, :6, SHARED + 3 :] = -(between @ own)
    columns = np.empty((len(told), SHARED + 6), np.intp)
    columns[:, :SHARED] = np.arange(SHARED)
    columns[:, SHARED : SHARED + 3] = SHARED + 3 * j[:, None] + np.arange(3)
    columns[:, SHARED + 3 :] = SHARED + 3 * i[:, None] + np.arange(3)
    weighted = weight[told, None, None] * J.swapaxes(1, 2)
    k = SHARED + 3 * len(M)
    H, g = np.zeros((k, k)), np.zeros(k)
    np.add.at(H, (columns[:, :, None], columns[:, None]), weighted @ found.H[told] @ J)
    np.add.at(g, columns, (weighted @ found.g[told, :, None])[..., 0])
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
