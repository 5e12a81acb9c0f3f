"""Camera and poses together: the least squares that OpenCV finds, with the same bits every time."""

import cv2
import numpy as np
import pytest
from rendered_boards import SIZE, TRUTH, views

from fusion.calibration.lens.fit.solve import NAMES, solve


def test_without_noise_the_camera_comes_back():
    solution = solve(views(8, 0.0), SIZE)
    assert solution.rms < 1e-6
    np.testing.assert_allclose(solution.parameters, TRUTH, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("hold_k3", [False, True])
def test_it_fits_as_well_as_opencv(hold_k3):
    seen = views(12, 0.3, 5)
    points = [np.ascontiguousarray(view.points, np.float32) for view in seen]
    pixels = [np.ascontiguousarray(view.pixels.reshape(-1, 1, 2), np.float32) for view in seen]
    flags = cv2.CALIB_FIX_K3 if hold_k3 else 0
    rms, K, lens, _, _ = cv2.calibrateCamera(points, pixels, SIZE, None, None, flags=flags)
    solution = solve(seen, SIZE, hold_k3=hold_k3)
    assert solution.rms <= rms * (1 + 1e-6)
    np.testing.assert_allclose(solution.parameters[:4], [K[0, 0], K[1, 1], K[0, 2], K[1, 2]], rtol=1e-5)
    assert not hold_k3 or solution.parameters[NAMES.index("k3")] == lens.ravel()[4] == 0


def test_every_time_the_same_bits():
    seen = views(10, 0.2, 1)
    first = solve(seen, SIZE)
    for _ in range(5):
        again = solve(seen, SIZE)
        assert np.array_equal(again.parameters, first.parameters)
        assert np.array_equal(again.poses, first.poses)


def test_a_bad_start_is_left_behind():
    seen = views(10, 0.1, 2)
    astray = np.array([1.3 * TRUTH[0], 0.8 * TRUTH[1], TRUTH[2] + 30, TRUTH[3] - 20, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(solve(seen, SIZE, astray).parameters, solve(seen, SIZE).parameters, rtol=1e-5, atol=1e-4)
