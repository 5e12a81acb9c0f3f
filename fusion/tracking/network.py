"""How well poses are known that edges hold: the covariance of a network, as in surveying."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import inverse
from fusion.tracking.graph import BELIEVED, LOOSE, Edge, held, linear, normal, settle, vectors

Array = NDArray[np.float64]
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
