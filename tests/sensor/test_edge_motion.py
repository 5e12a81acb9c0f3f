"""Speeds of edges in the image: of the surface in front, across themselves, as projection moves them."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.effects.rig.motion_blur import speed_of_edges
from fusion.sensor.view import Edges, View

CAMERA = Camera(65, 49, 60.0, 50.0, 32.0, 24.0)
NEAR, FAR, AT = 1.0, 1.4, 40.3  # depths [m] left and right of a column [px]
U = np.broadcast_to(np.arange(65.0), CAMERA.shape)


def step_view(velocity_near, velocity_far=(0.0, 0.0, 0.0)) -> View:
    left = U < AT
    edges = Edges(np.abs(U - AT), np.where(left, 0.0, np.pi), np.where(left, 0.4, -0.4), np.ones(CAMERA.shape))
    velocity = np.where(left[..., None], velocity_near, velocity_far)
    return View(CAMERA, np.where(left, NEAR, FAR), edges=edges, velocity=velocity)


@pytest.mark.parametrize("velocity", [(0.3, 0.0, 0.0), (-0.2, 0.5, 0.0), (0.0, 0.0, 0.6), (0.1, 0.1, -0.4)])
@pytest.mark.parametrize("column", [37, 40, 41, 43])
def test_is_the_speed_of_the_projected_edge(velocity, column):
    view = step_view(velocity, (5.0, 0.0, 0.0))
    where = np.array([20 * 65 + column])
    edge = np.array([(AT - 32.0) / 60.0, (20 - 24.0) / 50.0, 1.0]) * NEAR
    before, after = (CAMERA.project(edge + np.array(velocity) * t)[0, 0] for t in (-1e-4, 1e-4))
    away = (after - before) / 2e-4 * (1 if column < AT else -1)
    # rays are single precision
    assert speed_of_edges(where, view.depth, view)[0] == pytest.approx(away, rel=1e-5, abs=1e-5)


def test_what_is_not_known_stands_still():
    view = step_view((0.3, 0.0, 0.0))
    nothing = Edges(*(np.full(CAMERA.shape, np.nan) for _ in range(4)))
    where = np.arange(view.depth.size)
    for holey in (replace(view, velocity=np.full((49, 65, 3), np.nan)), replace(view, edges=nothing)):
        speed = speed_of_edges(where, view.depth, holey)
        assert np.isfinite(speed).all()
        assert holey.edges is nothing or not speed.any()
