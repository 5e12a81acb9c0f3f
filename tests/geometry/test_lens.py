"""Rays of lenses: OpenCV's own projection takes each back to its pixel, and what no pixel can show stays away."""

import cv2
import numpy as np
import pytest

from fusion.geometry.camera import OUTSIDE, Camera
from fusion.geometry.lens import beyond, growing

LENSES = {
    "tum fr1": (0.2624, -0.9531, -0.0054, 0.0026, 1.1633),
    "kinect v2": (0.0905, -0.2683, 0.0, 0.0, 0.0951),
    "barrel": (-0.25, 0.08, 0.002, -0.001),  # of which a fixed point's iteration leaves corners by pixels
    "pincushion": (0.3, 0.1, -0.003, 0.004, 0.05),
    "rational": (0.548, -0.021, 0.0003, -0.0002, -0.003, 0.89, 0.086, -0.014),
}


def camera(lens, focal=300.0):
    return Camera(640, 480, focal, focal * 1.01, 317.0, 243.0, distortion=lens)


def projected(camera, rays):
    points = np.concatenate([rays, np.ones((len(rays), 1))], axis=1)
    found, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, np.array(camera.distortion))
    return found.reshape(-1, 2)


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
def test_opencv_brings_each_ray_back_to_its_pixel(lens):
    seen = camera(lens)
    v, u = np.mgrid[0:480, 0:640]
    off = projected(seen, seen.rays().reshape(-1, 2).astype(float)) - np.column_stack([u.ravel(), v.ravel()])
    good = np.ones(seen.shape, bool) if seen.blind() is None else ~seen.blind()
    px = np.hypot(*off.T)[good.ravel()]
    # the last pixels before the lens turns back may be missed by 1e-4 of the focal length
    assert good.mean() > 0.9 and np.quantile(px, 0.999) < 1e-3 and px.max() < 0.03


def test_pixels_that_a_lens_does_not_reach_are_blind():
    """k1 = -0.3: r - 0.3 r^3 is largest, 0.7027, at r = 1.054."""
    seen = camera((-0.3,), 400.0)
    v, u = np.mgrid[0:480, 0:640]
    far = np.hypot((u - 317.0) / 400.0, (v - 243.0) / 404.0)
    assert (seen.blind() == (far > 0.7027)).mean() > 0.999
    assert np.isfinite(seen.rays()).all() and np.hypot(*seen.rays().reshape(-1, 2).T).max() < 1.055
    assert camera((0.3,)).blind() is None


def test_blind_pixels_do_not_look_into_the_middle_of_the_image():
    """Of this published lens Newton's method ended anywhere: a corner's pixel was drawn what stands in the middle."""
    seen = camera((0.102, -0.203, -0.0113, 0.0036, -0.111), 380.0)
    assert seen.blind().mean() > 0.01
    assert np.hypot(*seen.rays()[seen.blind()].T).min() > 0.8  # the lens turns back at 0.93


def test_points_beyond_a_lens_do_not_come_back_into_its_image():
    seen = camera((-0.3,), 400.0)
    points = np.array([[1.0, 0.0, 1.0], [1.1, 0.0, 1.0], [0.0, -1.8, 1.0], [3.2, 0.1, 2.0]])
    folded = projected(seen, points[:, :2] / points[:, 2:])
    assert (np.abs(folded) < 700).all()  # OpenCV's formula alone
    found = seen.project(points)
    np.testing.assert_allclose(found[0], folded[0])
    assert (found[1:] == OUTSIDE).all()


def test_a_lens_without_an_end_keeps_all():
    r, bent = growing(camera((0.1, 0.05)).distortion)
    assert r[-1] > 50 and (np.diff(bent) > 0).all()
    assert not beyond(np.array([3.0]), np.array([4.0]), camera((0.1, 0.05)).distortion).any()
