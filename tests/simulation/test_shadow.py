"""Shadows of a square before a wall, whose outline is known exactly."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.render import Channels, render
from fusion.simulation.scene.shapes import joined, sheet

CAMERA = Camera(320, 120, 300.0, 300.0, 160.2, 60.3)


def square(half: float, z: float) -> Mesh:
    corners = half * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) + [0, 0, z]
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))


@pytest.mark.parametrize("x", [-0.075, 0.05])
def test_a_shadow_is_as_wide_as_the_disparities_differ_and_on_the_far_side_of_the_projector(x):
    near, far = 0.8, 2.0
    view = render(joined([square(0.1, near), square(4, far)]), CAMERA, np.eye(4), Channels(lit=x))
    row = view.lit[60]
    width = CAMERA.fx * abs(x) * (1 / near - 1 / far)
    assert (1 - row).sum() == pytest.approx(width, abs=0.3)  # a quarter of a pixel at each end
    dark = np.flatnonzero(row < 0.5)
    right, left = CAMERA.cx + CAMERA.fx * 0.1 / near, CAMERA.cx - CAMERA.fx * 0.1 / near
    if x < 0:  # projector to the left, shadow to the right
        assert dark[0] == pytest.approx(right, abs=1) and dark[-1] == pytest.approx(right + width, abs=1)
    else:
        assert dark[-1] == pytest.approx(left, abs=1) and dark[0] == pytest.approx(left - width, abs=1)
    assert (view.lit[view.depth < 1] >= 0.5).all()  # but for shares of pixels on the outline


def test_a_lamp_at_the_camera_reaches_all_that_is_seen():
    mesh = joined([square(0.1, 0.8), square(4, 2.0)])
    assert (render(mesh, CAMERA, np.eye(4), Channels(lit=0.0)).lit == 1).all()


def test_surfaces_do_not_shade_themselves():
    # 0.3 m to 10 m away, and tilted until the projector nearly grazes them
    for z in (0.3, 1.0, 10.0):
        assert (render(square(20 * z, z), CAMERA, np.eye(4), Channels(lit=-0.075)).lit == 1).all()
    x, y, z = np.eye(3)
    floor = sheet(-5 * x + 0.2 * y + 0.3 * z, 10 * x, 8 * z, lambda p: np.full((len(p), 3), 100))
    assert (render(floor, CAMERA, np.eye(4), Channels(lit=-0.075)).lit == 1).all()


def test_a_face_turned_away_from_the_projector_is_dark():
    # a wall along the optical axis, seen by the camera from the right, its front not by a projector further left
    x, y, z = np.eye(3)
    wall = sheet(-0.05 * x - y + 0.5 * z, 2 * y, 4 * z, lambda p: np.full((len(p), 3), 100))
    view = render(wall, CAMERA, np.eye(4), Channels(lit=-0.1))
    seen = np.isfinite(view.depth)
    assert seen.any() and not view.lit[seen].any()
    assert (render(wall, CAMERA, np.eye(4), Channels(lit=0.1)).lit == 1).all()
    assert (view.lit[~seen] == 1).all()
