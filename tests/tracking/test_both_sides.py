"""What holds an alignment: shape that both sides see, or the noise of normals, which each has for itself."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.tracking.icp import align

CAMERA = Camera(160, 120, 145.0, 145.0, 79.5, 59.5)
NOISE = 0.006  # [m] alike over a matching window, so that normals of single frames lean by several degrees


def wall(seed, steps=0.0, moved=0.0):
    """(120, 160) [m] a wall at 1.5 m, or one with a wave of a height [m], after the camera moved right."""
    rng = np.random.default_rng(seed)
    x = CAMERA.rays()[..., 0] * 1.5 + moved
    fine = rng.standard_normal((30, 40)).repeat(4, axis=0).repeat(4, axis=1)
    depth = 1.5 + steps * np.sin(12 * x) * np.cos(9 * CAMERA.rays()[..., 1] * 1.5) + NOISE * fine
    return point_map(depth.astype(np.float32), CAMERA, NOISE)


@pytest.mark.parametrize("seed", range(4))
def test_the_noise_of_a_plane_holds_nothing(seed):
    found = align(wall(seed, moved=0.02), wall(seed + 10), np.eye(4))
    assert {"shift x", "shift y"} <= set(found.unconstrained)


@pytest.mark.parametrize("seed", range(4))
def test_relief_above_the_noise_holds(seed):
    found = align(wall(seed, 0.06, 0.02), wall(seed + 10, 0.06), np.eye(4))
    assert not {"shift x", "shift y"} & set(found.unconstrained)
    np.testing.assert_allclose(found.T_model_source[:2, 3], [0.02, 0], atol=0.006)
