"""A pose that was found in the images of a wrong camera is wrong with it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, inverse, transform
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.optics.principal_point import PrincipalPoint
from fusion.sensor.laws.moving import found_again
from fusion.sensor.view import View
from fusion.simulation.rendering.render import Channels, RayCaster

CAMERA = Camera(160, 120, 150.0, 150.0, 80.0, 60.0, principle="itof")
EFFECTS = (FocalLength(relative=0.03), PrincipalPoint(cx=2.0, cy=-3.0))


def seen(camera, T_camera_board):
    return RayCaster(board()).view(camera, inverse(T_camera_board), Channels())


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_the_bias_is_the_depth_that_the_true_camera_measures(effect, principle):
    stated = replace(CAMERA, principle=principle)
    true = effect.true_camera(stated)
    T_true = exp([0.3, -0.4, 0.1, 0.1, 0.05, 1.2])
    T_stated = pose_from_image(T_true, true, stated)
    truth = seen(true, T_true)
    view = replace(seen(stated, T_stated), placed_by_images=True)
    measured = truth.depth * truth.stretch / view.stretch if principle == "itof" else truth.depth
    both = np.isfinite(measured) & np.isfinite(view.depth)
    wrong = (measured - view.depth)[both]
    left = wrong - effect.change(view.depth, view)[both]
    # points spread over the plate instead of its corners: they share out otherwise what no pose can follow
    assert np.abs(left).max() < 0.08 * np.abs(wrong).max()
    fixed = effect.change(view.depth, replace(view, placed_by_images=False))
    assert np.abs(wrong - fixed[both]).max() > 0.3 * np.abs(wrong).max()


def test_a_focal_length_too_long_puts_a_frontal_board_too_far_away():
    view = seen(CAMERA, exp([0, 0, 0, 0, 0, 1.0]))
    T = found_again(FocalLength(relative=0.02).true_camera(CAMERA), view)
    # exact for a board parallel to the image; the renderer works in single precision
    assert T[:3, 3] == pytest.approx([0, 0, 1 / 1.02 - 1], abs=1e-5)


def test_nothing_seen_moves_nothing():
    nothing = View(CAMERA, np.full(CAMERA.shape, np.nan, np.float32))
    assert np.array_equal(found_again(FocalLength(relative=0.02).true_camera(CAMERA), nothing), np.eye(4))


def board():
    corners = np.array([[-0.15, -0.1, 0], [0.15, -0.1, 0], [0.15, 0.1, 0], [-0.15, 0.1, 0]])
    return Mesh(corners, np.array([[0, 2, 1], [0, 3, 2]], np.int32))


def pose_from_image(T_true, true, stated):
    """What anybody's board detection gives: the corners where the true camera sees them, through the stated one."""
    x, y = np.meshgrid(np.linspace(-0.15, 0.15, 7), np.linspace(-0.1, 0.1, 5))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    at = transform(T_true, points)
    pixels = at[:, :2] / at[:, 2:] * [true.fx, true.fy] + [true.cx, true.cy]
    K = np.array([[stated.fx, 0, stated.cx], [0, stated.fy, stated.cy], [0, 0, 1]])
    _, turned, shift = cv2.solvePnP(points, pixels, K, None)
    return exp([*turned.ravel(), *shift.ravel()])
