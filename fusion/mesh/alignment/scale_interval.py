"""How well a fitted scale is known, with errors that are alike in neighbouring places."""

import numpy as np
from scipy.special import stdtrit  # scipy.stats takes a second to import

from fusion.mesh.alignment.similarity import AS_WELL, Array, Matches, solve, tells_scale

# parts along x, y, z: cubes, as errors may reach across half of the object or be gone after a few pixels; and slabs,
# as what has no counterpart (a plate below) pulls at one end
_PARTS = ((2, 2, 2), (3, 3, 3), (4, 4, 4), (6, 6, 6), (6, 1, 1), (1, 6, 1), (1, 1, 6))
UNKNOWN = 0.0, float("inf")  # interval of a scale of which nothing is known
_FLOAT = 1e-7  # closest points are float32


def scale_interval(scale: float, scale_back: float, matches: Matches) -> tuple[float, float]:
    """95 % interval of the scale; (0, inf) where the shape says nothing about it.

    Two parts, added as squares. The random one is a jackknife over blocks of space (as cluster-robust as CR3 of Bell
    and McCaffrey 2002), at several sizes of blocks, the widest of which counts: blocks smaller than the reach of the
    errors make them look independent. The other one is how far the scale moves when the reference is laid on the
    mesh instead of the mesh on the reference: noise rounds edges and swells what is curved, in one direction and in
    the other one differently, and what has no counterpart pulls in one direction only.

    Args:
        scale: of the mesh, as fitted by laying it on the reference.
        scale_back: of the mesh, as fitted by laying the reference on it.
        matches: of the first fit, points of the mesh and where they belong on the reference.
    """
    if np.count_nonzero(matches.weights) < 8 or not tells_scale(matches):
        return UNKNOWN
    random = max(_jackknife(matches, parts) for parts in _PARTS)
    half = float(np.hypot(random, np.log(scale_back / scale))) + _FLOAT
    return scale * float(np.exp(-half)), scale * float(np.exp(half))


def scale_asked_for(matches: Matches) -> float | None:
    """The scale that the last matches of a fit without one ask for; None where 1 is as good.

    By its random part alone (see `scale_interval`), and where what is left would be clearly less with it.
    """
    if np.count_nonzero(matches.weights) < 8 or not tells_scale(matches):
        return None
    jacobian, residual, _, size = matches.rows
    weighted = jacobian * matches.weights[:, None]
    system, right = weighted.T @ jacobian, weighted.T @ residual
    with_scale, without = solve(system, right), solve(system[:6, :6], right[:6])
    total = float(matches.weights @ residual**2)
    left = [max(total - float(asked @ found), 0.0) for asked, found in ((right, with_scale), (right[:6], without))]
    asked = float(with_scale[6]) / size
    random = max(_jackknife(matches, parts) for parts in _PARTS)
    return float(np.exp(asked)) if AS_WELL**2 * left[0] < left[1] and abs(asked) > random + _FLOAT else None


def _jackknife(matches: Matches, parts: tuple[int, int, int]) -> float:
    """Half of the 95 % interval of the scale's logarithm, from leaving out one block of space after the other."""
    jacobian, residual, _, size = matches.rows
    counted = np.flatnonzero(matches.weights > 0)
    jacobian, residual, weights = jacobian[counted], residual[counted], matches.weights[counted]
    block = _blocks(matches.points[counted], parts)
    weighted = jacobian * weights[:, None]
    systems = np.stack([weighted[rows].T @ jacobian[rows] for rows in block])
    rights = np.stack([weighted[rows].T @ residual[rows] for rows in block])
    share = np.array([weights[rows].sum() for rows in block]) / weights.sum()
    effective = 1 / float(np.square(share).sum())  # blocks of equal weight that say as much
    if len(block) < 3 or effective < 2:
        return 0.0  # said by the other sizes
    system, right = systems.sum(axis=0), rights.sum(axis=0)
    whole = solve(system, right)[6] / size
    without = np.array([solve(system - a, right - b)[6] for a, b in zip(systems, rights, strict=True)]) / size
    error = float(np.sqrt((len(block) - 1) / len(block) * np.square(without - whole).sum()))
    return float(stdtrit(effective - 1, 0.975)) * error


def _blocks(points: Array, parts: tuple[int, int, int]) -> list[Array]:
    """Rows of the points in each of the cells that cut their box into parts along x, y, z."""
    low, extent = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-12)
    place = np.minimum((points - low) / extent * parts, np.array(parts) - 1).astype(int)
    cell = place @ [1, parts[0], parts[0] * parts[1]]
    order = np.argsort(cell, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(cell[order])) + 1)
