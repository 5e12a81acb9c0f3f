import numpy as np
import pytest

from fusion.geometry.pose import angle, exp, inverse
from fusion.tracking.graph import Edge, parts, settle

N = 24
SIGMA = np.repeat([0.005, 0.01], 3)  # [rad], [m]


def ring():
    """Camera poses on a circle that look outwards; the first is the identity."""
    poses = [exp([0, 0.0, 0, 0, 0, -1.0])]
    poses = [exp([0, 2 * np.pi * k / N, 0, 0, 0, 0]) @ exp([0, 0, 0, 0, 0, 1.0]) for k in range(N)]
    return inverse(poses[0]) @ np.stack(poses)


def edge(truth, i, j, error=None, doubtful=False, sigma=SIGMA):
    T = inverse(truth[i]) @ truth[j]
    measured = T if error is None else exp(error) @ T
    return Edge(i, j, measured, np.diag(sigma**-2.0), np.zeros(3), doubtful)


def drifted(edges):
    poses = [np.eye(4)]
    for one in edges:
        poses.append(poses[-1] @ one.T_i_j)
    return np.stack(poses)


@pytest.fixture
def truth():
    return ring()


@pytest.fixture
def chain(truth):
    rng = np.random.default_rng(3)
    return [edge(truth, k, k + 1, SIGMA * rng.standard_normal(6)) for k in range(N - 1)]


def worst(poses, truth):
    apart = [inverse(a) @ b for a, b in zip(truth, poses, strict=True)]
    return max(np.linalg.norm(T[:3, 3]) for T in apart), max(map(angle, apart))


def test_edges_that_agree_are_met_exactly(truth):
    edges = [edge(truth, k, (k + 1) % N) for k in range(N)]
    start = truth @ np.stack([exp(0.02 * np.sin(np.arange(6) + k)) if k else np.eye(4) for k in range(N)])
    settled = settle(start, edges)
    assert worst(settled.poses, truth)[0] < 1e-6
    assert settled.errors.max() < 1e-3


def test_a_closed_loop_takes_the_drift_out(truth, chain):
    start = drifted(chain)
    closing = [edge(truth, 0, N - 1, doubtful=True, sigma=0.1 * SIGMA), edge(truth, 1, N - 1, doubtful=True)]
    settled = settle(start, chain + closing)
    assert (settled.weights > 0.9).all()
    end = inverse(truth[-1]) @ settled.poses[-1]
    assert np.linalg.norm(end[:3, 3]) < 0.01 < np.linalg.norm((inverse(truth[-1]) @ start[-1])[:3, 3])
    assert worst(settled.poses, truth)[0] < 0.6 * worst(start, truth)[0]


def test_a_wrong_closing_is_refused(truth, chain):
    good = [edge(truth, k, N - 1 - k, doubtful=True) for k in range(3)]
    bad = edge(truth, 4, 15, [0.3, 0.2, 0.0, 0.5, -0.4, 0.2], doubtful=True)
    settled = settle(drifted(chain), [*chain, *good, bad])
    assert settled.weights[-1] < 0.1 and (settled.weights[:-1] > 0.5).all()
    without = settle(drifted(chain), [*chain, *good])
    # what is left of it: the loss of Geman and McClure never lets go altogether
    assert worst(settled.poses, without.poses)[0] < 0.01


def test_a_direction_that_no_edge_fixes_stays(truth):
    open_edge = edge(truth, 0, 1, [0, 0, 0, 0.1, 0.0, 0.05], sigma=np.array([0.01, 0.01, 0.01, 1e9, 0.01, 0.01]))
    settled = settle(truth[:2], [open_edge])
    apart = settled.poses[1] @ inverse(truth[1])
    assert np.allclose(apart[:3, 3], [0.0, 0.0, 0.05], atol=1e-4)


def test_parts_that_nothing_joins_are_settled_each(truth, chain):
    edges = [one for one in chain if one.i != 9]
    assert np.array_equal(np.unique(parts(N, edges)), [0, 10])
    settled = settle(truth, edges)
    assert np.array_equal(settled.poses[10], truth[10])
    assert np.array_equal(settle(truth, []).poses, truth)
