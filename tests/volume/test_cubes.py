"""The generated case table."""

import numpy as np
import pytest

from fusion.volume.extraction.cubes import EDGES, table


def test_a_case_uses_the_crossed_edges_only():
    for case, row in enumerate(table()):
        crossed = {e for e, (a, b) in enumerate(EDGES) if (case >> a & 1) != (case >> b & 1)}
        assert set(row[row >= 0].tolist()) == crossed


@pytest.mark.parametrize("seed", range(3))
def test_any_field_has_a_closed_surface(seed):
    """A random field, outside all around, meets every case and every ambiguous face: still no cracks, no forks."""
    rng = np.random.default_rng(seed)
    inside = np.zeros((14, 14, 14), bool)
    inside[1:-1, 1:-1, 1:-1] = rng.random((12, 12, 12)) < 0.5
    corners = np.array([(o // 4, o // 2 % 2, o % 2) for o in range(8)])
    directed = {}
    for cell in np.ndindex(13, 13, 13):
        case = sum(1 << o for o in range(8) if inside[tuple(cell + corners[o])])
        row = table()[case]
        for triangle in row[row >= 0].reshape(-1, 3):
            ids = [(*(cell + corners[EDGES[e][0]]), int(e) // 4) for e in triangle]
            for pair in zip(ids, ids[1:] + ids[:1], strict=True):
                directed[pair] = directed.get(pair, 0) + 1
    assert all(n == 1 and directed.get((b, a)) == 1 for (a, b), n in directed.items())
