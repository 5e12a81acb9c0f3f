import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.geometry.pose import angle, exp, inverse, transform
from fusion.tracking.landmarks import Landmarks, landmarks, meet

T = exp([0.1, -0.3, 0.2, 0.4, -0.1, 0.2])


def made(rng, n=120, noise=0.005):
    """The same points in two cameras, with equal descriptors."""
    points = rng.uniform([-1, -1, 1], [1, 1, 3], (n, 3))
    descriptors = rng.integers(0, 256, (n, 32), dtype=np.uint8)
    sigma = np.full(n, noise)
    b = Landmarks(points + noise * rng.standard_normal((n, 3)), sigma, descriptors)
    return Landmarks(transform(T, points), sigma, descriptors), b


def test_the_motion_is_found_as_exactly_as_its_information_says():
    a, b = made(np.random.default_rng(0))
    met = meet(a, b)
    assert met.count > 100
    apart = met.T_a_b @ inverse(T)
    shift = transform(apart, met.centre) - met.centre
    sigma = np.sqrt(np.diag(np.linalg.inv(met.information)))
    assert (np.abs(shift) < 4 * sigma[3:]).all() and angle(apart) < 4 * sigma[:3].max()


def test_wrong_matches_are_left_out():
    rng = np.random.default_rng(1)
    a, b = made(rng)
    wrong = rng.permutation(120)[:80]
    points = b.points.copy()
    points[wrong] = rng.uniform([-1, -1, 1], [1, 1, 3], (80, 3))
    met = meet(a, Landmarks(points, b.sigma, b.descriptors))
    assert 30 <= met.count <= 50
    assert angle(met.T_a_b @ inverse(T)) < 0.02


@pytest.mark.parametrize("n", [0, 10])
def test_too_few_meet_nothing(n):
    a, b = made(np.random.default_rng(2), n)
    assert meet(a, b) is None


def test_views_of_different_things_do_not_meet():
    rng = np.random.default_rng(3)
    assert meet(made(rng)[0], made(rng)[1]) is None


def test_an_image_gives_landmarks_where_there_is_surface():
    camera = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
    rng = np.random.default_rng(4)
    grey = np.kron(rng.integers(0, 256, (15, 20), dtype=np.uint8), np.ones((8, 8), np.uint8))
    depth = np.full(camera.shape, 1.5, np.float32)
    depth[:, 80:] = np.nan
    found = landmarks(grey, point_map(depth, camera))
    assert len(found) > 20 and (found.points[:, 0] < 0.05).all() and np.allclose(found.points[:, 2], 1.5)
    assert len(landmarks(np.full(camera.shape, 9, np.uint8), point_map(depth, camera))) == 0
