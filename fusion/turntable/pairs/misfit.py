"""How badly turns bring views onto each other: many pairs of views and turns at a time."""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.axis import Turns
from fusion.turntable.pairs.edges import PART, AskedErrors, Edges, ViewStack, paired
from fusion.turntable.selfcheck import NAMES, SelfCheck

Array = NDArray[np.float64]
LEAST_COSINE = 0.5  # between the normals of a pair: the turn may be wrong by much
NO_ERRORS = SelfCheck(np.zeros(len(NAMES)), 0.0, 1.0)


def misfits(seen: ViewStack, edges: Edges, motion: Turns, reach: float, check: SelfCheck = NO_ERRORS) -> Array:
    """How badly each turn fits: (m,) from 0 (perfect) to 1 (nothing fits).

    Points that the other view looked through count as wrong as points far off; points that it cannot see are left out.

    Args:
        seen: the views as the camera file has them.
        edges: m pairs of views, source and model.
        motion: axis, and the turn (m,) [rad] that is tried for each of them.
        reach: largest distance of a pair [m], see `Stack.reach`.
        check: errors of camera and depth.
    """
    axis, turns = motion
    part = max(1, PART // max(int(np.max(np.diff(seen.first))), 1))
    some = [slice(k, k + part) for k in range(0, len(edges), part)]
    return np.concatenate([np.zeros(0), *(_some(seen, edges[s], Turns(axis, turns[s]), reach, check) for s in some)])


def _some(seen: ViewStack, edges: Edges, motion: Turns, reach: float, check: SelfCheck) -> Array:
    from fusion.turntable.pairs.edge_pairs import PAIRED, SEEN

    code, out = paired(seen, motion, edges, (reach, LEAST_COSINE), AskedErrors(check))
    pair = code == PAIRED
    far = np.ones(code.shape, np.float32)
    np.divide(out[..., 0], 0.5 * seen.reach(reach), out=far, where=pair)
    visible = np.asarray(np.sum(code >= SEEN, axis=1), float)
    wrong = np.sum(np.minimum(far**2, 1), axis=1, where=code >= SEEN)
    points = np.diff(seen.first)[[i for i, _ in edges]]
    known = visible >= np.maximum(0.2 * points, 50)
    return np.where(known, wrong / np.maximum(visible, 1), 1.0)
