"""What two views of a surface say of each other does not grow with the noise of their normals."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.tracking.both_sides import by_relief
from fusion.tracking.equations import PairLimits, equations, lay_out
from fusion.tracking.icp import IcpSettings, align_points

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
SIGMA = 0.008  # [m] makes normals of such an image err by a tenth and more
HOW = IcpSettings(points=(6000,), reaches=(0.1,), iterations=(6,))


def seen(depth, seed):
    noise = SIGMA * np.random.default_rng(seed).standard_normal(depth.shape)
    return point_map((depth + noise).astype(np.float32), CAMERA, SIGMA)


def weakest(depth):
    """Least information about a shift, by the model's normals alone and by both views' [1 / m^2]."""
    model, source = seen(depth, 1), lay_out(seen(depth, 2), 6000)
    found = align_points(source, model, np.eye(4), HOW)
    alone = equations(source, found.T_model_source, model, PairLimits(HOW.reaches[-1], HOW.min_cosine)).information
    both = by_relief(alone, source, model, found.T_model_source, HOW.reaches[-1])
    return [float(np.linalg.eigvalsh(x[3:, 3:])[0]) for x in (alone, both)]


def test_a_noisy_wall_leaves_its_own_directions_open():
    alone, both = weakest(np.full(CAMERA.shape, 1.5))
    # what is left are chance products of some thousand normals: a thirtieth of their squares
    assert both < 0.1 * alone


def test_a_corner_keeps_what_it_tells():
    v, u = np.mgrid[0:120, 0:160]
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    # three walls square to each other, the corner ahead: of all planes through it the nearest along each ray
    normals = np.array([[0.8165, 0, 0.5774], [-0.4082, 0.7071, 0.5774], [-0.4082, -0.7071, 0.5774]])
    depth = np.min([1.5 * n[2] / np.maximum(n[0] * x + n[1] * y + n[2], 1e-3) for n in normals], axis=0)
    alone, both = weakest(depth)
    assert both > 0.7 * alone


@pytest.mark.parametrize("shift", [5.0, np.nan])
def test_views_that_do_not_meet_say_nothing(shift):
    T = np.eye(4)
    T[0, 3] = shift
    wall = seen(np.full(CAMERA.shape, 1.5), 1)
    assert not by_relief(np.eye(6), lay_out(wall, 6000), wall, T, 0.1).any()
