"""Lenses of other forms: held against OpenCV's own fisheye, and against formulas written out here."""

import cv2
import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.lens_forms import fisheye, polynomial, to_fisheye, to_polynomial, with_lens

# widths of view from 60 to 130 degrees over the diagonal
CASES = [
    (700.0, (0.01, -0.02, 0.01, -0.003)),
    (400.0, (0.0, 0.0, 0.0, 0.0)),
    (400.0, (-0.02, 0.005, -0.003, 0.0005)),
    (380.0, (0.12, -0.05, 0.02, -0.004)),
    (360.0, (-0.05, 0.02, -0.01, 0.002)),
]


def plain(f):
    return Camera(640, 480, f, 1.01 * f, 322.4, 236.1)


def rays_within(camera):
    rays = camera.rays().reshape(-1, 2)[::37].astype(float)
    return np.column_stack([rays, np.ones(len(rays))])


@pytest.mark.parametrize(("f", "k"), CASES)
def test_fisheye_as_opencv_projects_it(f, k):
    camera, gap = with_lens(plain(f), fisheye(k))
    points = rays_within(camera)
    K = camera.matrix
    expected, _ = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), K, np.array(k))
    assert gap < 0.02
    assert np.abs(camera.project(points) - expected.reshape(-1, 2)).max() < 0.02


@pytest.mark.parametrize(("f", "k"), CASES)
def test_rays_of_the_pixels_as_opencv_finds_them(f, k):
    camera, _ = with_lens(plain(f), fisheye(k))
    v, u = np.mgrid[0:480:23, 0:640:29]
    pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2).astype(float)
    expected = cv2.fisheye.undistortPoints(pixels, camera.matrix, np.array(k)).reshape(-1, 2)
    found = camera.rays()[v, u].reshape(-1, 2)
    turn = np.degrees(np.abs(np.arctan(np.hypot(*found.T)) - np.arctan(np.hypot(*expected.T))))
    assert turn.max() < 0.003  # 0.02 px of 400


@pytest.mark.parametrize(("f", "k"), CASES)
def test_fisheye_and_back(f, k):
    camera, _ = with_lens(plain(f), fisheye(k))
    r = np.linspace(0, np.abs(camera.rays()).max(), 100)
    assert np.abs(fisheye(to_fisheye(camera))(r) - fisheye(k)(r)).max() * f < 0.04


def test_four_radial_terms_with_tangential_ones():
    k, p1, p2 = (-0.31, 0.12, -0.03, 0.004), 3e-4, -2e-4
    camera, gap = with_lens(plain(575.0), polynomial(k), (p1, p2))
    x, y, _ = rays_within(camera).T
    q = x * x + y * y
    radial = 1 + k[0] * q + k[1] * q**2 + k[2] * q**3 + k[3] * q**4
    u = camera.fx * (x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x)) + camera.cx
    v = camera.fy * (y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y) + camera.cy
    assert gap < 1e-3
    assert np.abs(camera.project(rays_within(camera)) - np.stack([u, v], axis=1)).max() < 2e-3
    back, r = to_polynomial(camera), np.linspace(0, np.abs(camera.rays()).max(), 100)
    assert np.abs(polynomial((*back, 0.0))(r) - polynomial(k)(r)).max() * 575 < 0.2


def test_what_no_quotient_follows_is_refused():
    with pytest.raises(ValueError, match="does not reach"):
        with_lens(plain(575.0), polynomial((-1.2, 0.0, 0.0, 0.0)))  # folds back within the image
    with pytest.raises(ValueError, match="does not reach"):
        with_lens(plain(180.0), fisheye((0.0, 0.0, 0.0, 0.0)))  # sees more than a half space
