"""The covariance of a network of poses is the spread of what it is drawn from, whatever its edges claim."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.pose import inverse, pose, rotation
from fusion.reconstruction.loops.network import spread_of
from fusion.tracking.graph import Edge, settle

SIGMA = np.repeat([1e-3, 2e-3], 3)  # [rad], [m] of an edge
COUNT = 14


def course():
    """(k, 4, 4) places along a bow."""
    return np.stack([pose(rotation(np.array([0, 0.08 * k, 0])), [0.1 * k, 0, 0.02 * k * k]) for k in range(COUNT)])


def drawn(true, rng, claim=1.0):
    """Edges between neighbours, next but one and both ends, each off by a draw; they claim `claim` times the spread."""
    pairs = [(k, k + step) for step in (1, 2, 3) for k in range(len(true) - step)] + [(0, len(true) - 1)]
    out = []
    for i, j in pairs:
        off = SIGMA * rng.standard_normal(6)
        T = pose(rotation(off[:3]), off[3:]) @ inverse(true[i]) @ true[j]
        out.append(Edge(i, j, T, np.diag((claim * SIGMA) ** -2.0), np.zeros(3), True, "surface"))
    return out


def twists(poses, true):
    from scipy.spatial.transform import Rotation

    apart = poses @ inverse(true)
    return np.concatenate([Rotation.from_matrix(apart[:, :3, :3]).as_rotvec(), apart[:, :3, 3]], axis=1)


@pytest.mark.parametrize("claim", [1.0, 20.0, 0.5])
def test_the_spread_is_that_of_the_errors(claim):
    rng, true, errors, told = np.random.default_rng(1), course(), [], []
    for _ in range(60):
        edges = drawn(true, rng, claim)
        settled = settle(true, edges).poses
        errors.append(twists(settled, true))
        told.append(np.diag(spread_of(settled, edges)).reshape(-1, 6))
    found, said = np.sqrt(np.mean(np.square(errors), axis=0))[1:], np.sqrt(np.mean(told, axis=0))[1:]
    # 60 draws tell a standard deviation to 9 %, and each network its own factor to 10 %
    assert said.mean(axis=0) == pytest.approx(found.mean(axis=0), rel=0.2)


def test_poses_that_edges_would_have_elsewhere_are_less_sure():
    true = course()
    edges = drawn(true, np.random.default_rng(2))
    settled = settle(true, edges).poses
    bent = settled.copy()
    bent[:, 0, 3] += np.linspace(0, 0.05, COUNT)
    there, here = (np.sqrt(spread_of(poses, edges)[-3, -3]) for poses in (bent, settled))
    assert there > 0.04 > 5 * here


def test_an_edge_without_a_kind_keeps_what_it_states():
    true = course()
    tracked = [
        replace(edge, kind="", T_i_j=inverse(true[edge.i]) @ true[edge.j])
        for edge in drawn(true, np.random.default_rng(3))
    ]
    alone = np.sqrt(np.diag(spread_of(true, tracked)))
    assert alone[6:].min() > 0.2 * SIGMA.min()
