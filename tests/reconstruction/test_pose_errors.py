"""What poses are wrong by together moves a surface, but for what laying it on the truth takes away."""

import numpy as np
import pytest

from fusion.certainty.looks import Looks
from fusion.geometry.pose import pose
from fusion.reconstruction.loops.network import PoseErrors

VIEWS, POINTS = 5, 400


def scene():
    """Points of a box with normals, views each of which sees a fifth of it."""
    rng = np.random.default_rng(4)
    normals = np.eye(3)[rng.integers(0, 3, POINTS)]
    points = rng.uniform(-1, 1, (POINTS, 3))
    weight = np.zeros((POINTS, VIEWS), np.float32)
    weight[np.arange(POINTS), rng.integers(0, VIEWS, POINTS)] = 1
    poses = np.stack([pose(np.eye(3), [0.1 * k, 0, 0]) for k in range(VIEWS)])
    nothing = np.zeros_like(weight)
    return points, normals, Looks(nothing, nothing, weight, np.zeros((VIEWS, VIEWS)), poses, np.ones(POINTS)), poses


def test_a_common_motion_is_no_error():
    points, normals, looks, poses = scene()
    same = np.tile(np.array([0.01, -0.02, 0.03, 0.1, 0.2, -0.1])[None, :, None], (2, 1, 1))
    along = PoseErrors(np.array([0, VIEWS - 1]), same, poses).along(points, normals, looks)
    assert along == pytest.approx(0, abs=1e-9)


def test_views_that_stand_apart_are():
    points, normals, looks, poses = scene()
    apart = np.zeros((VIEWS, 6, 1))
    apart[VIEWS // 2, 3] = 0.01  # one view stands 10 mm aside
    along = PoseErrors(np.arange(VIEWS), apart, poses).along(points, normals, looks)
    seen = looks.weight[:, VIEWS // 2].astype(bool) & (normals[:, 0] == 1)
    # laid on the truth with all others, it keeps four fifths, and they take up a fifth
    assert np.median(along[seen]) == pytest.approx(0.008, rel=0.15)
    assert np.median(along[~seen]) < 0.003
