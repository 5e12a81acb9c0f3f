"""Steps that are left out before a closer look are none that it would have kept."""

import numpy as np
import pytest

from fusion.simulation.ideal import edges
from fusion.simulation.ideal.frame import IdealFrame


def image(rng, shape) -> np.ndarray:
    """Waves with boxes before them and holes."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    depth = (1.5 + 0.3 * np.sin(u / rng.uniform(2, 60)) + 0.2 * np.cos(v / rng.uniform(2, 45))).astype(np.float32)
    for _ in range(5):
        a, b = rng.integers(0, shape[0]), rng.integers(0, shape[1])
        depth[a : a + rng.integers(1, 40), b : b + rng.integers(1, 40)] = rng.choice([rng.uniform(0.5, 2), np.nan])
    depth[rng.random(shape) < rng.choice([0.0, 0.02])] = np.nan
    return depth


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("shape", [(60, 80), (1, 7), (2, 3), (7, 1), (3, 2)])
def test_the_same_edges_with_and_without(axis, shape, monkeypatch):
    rng = np.random.default_rng(6)
    for turn in range(20):
        depth = image(rng, shape)
        labels = rng.integers(0, 3, shape) if turn % 4 == 0 else None
        frame = IdealFrame(depth, segmentation=labels, rounding=0.001 * (turn % 3 == 0))
        with np.errstate(all="ignore"):
            quick = edges.torn(1 / depth, frame, axis)
            with monkeypatch.context() as around:
                around.setattr(edges, "calm", lambda step, *_: np.zeros(len(step), bool))
                slow = edges.torn(1 / depth, frame, axis)
        for one, other in zip(quick, slow, strict=True):
            np.testing.assert_array_equal(one, other)
