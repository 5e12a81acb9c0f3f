"""A lens of 120 degrees, projected by OpenCV's fisheye functions: the eight terms are found, and only where needed."""

import cv2
import numpy as np
import pytest
from rendered_boards import views

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.fit.terms import is_rational
from fusion.calibration.lens.intrinsics import fit_camera
from fusion.calibration.lens.views import view_of

SIZE, K = (512, 512), np.array([[252.0, 0, 255.3], [0, 252.4, 257.1], [0, 0, 1]])
LENS = np.array([0.03, -0.01, 0.004, -0.001])
BOARD = Board(9, 6, 0.04)
NOISE_PX = 0.05


def seen(count=24, seed=3):
    """Views of a board over the whole image; corners outside of it are not seen."""
    rng, made = np.random.default_rng(seed), []
    points = BOARD.points().astype(float)
    while len(made) < count:
        side = rng.uniform(-1.2, 1.2, 2)
        turn = np.array([-side[1], side[0], 0]) * 0.5 + rng.normal(0, 0.25, 3)
        place = np.array([*side, 1.0]) * rng.uniform(0.3, 0.5)
        place -= cv2.Rodrigues(turn)[0] @ points.mean(axis=0)
        pixels, _ = cv2.fisheye.projectPoints(points[:, None], turn, place, K, LENS)
        pixels = pixels.reshape(-1, 2) + rng.normal(0, NOISE_PX, (len(points), 2))
        if ((pixels > 3) & (pixels < 508)).all():
            made.append(view_of(f"view_{len(made):02d}", pixels, BOARD))
    return made


def rays():
    """(n, 3) of the pixels of the whole image but its corners, where no board was seen."""
    v, u = np.mgrid[0:512:16, 0:512:16]
    keep = np.hypot(u - 255.5, v - 255.5) < 250
    pixels = np.stack([u[keep], v[keep]], axis=1).astype(float)
    xy = cv2.fisheye.undistortPoints(pixels[:, None], K, LENS).reshape(-1, 2)
    return pixels, np.column_stack([xy, np.ones(len(xy))])


def off(camera):
    """How far [px] the camera's pixels lie from the truth's over the image: a turn of the whole is a pose's."""
    pixels, directions = rays()
    found = camera.rays()[pixels[:, 1].astype(int), pixels[:, 0].astype(int)].astype(float)
    mine = np.column_stack([found, np.ones(len(found))])
    mine /= np.linalg.norm(mine, axis=1, keepdims=True)
    true = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(mine.T @ true)
    turned = mine @ u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    apart = np.degrees(np.arccos(np.clip((turned * true).sum(axis=1), -1, 1)))
    return np.radians(apart) * 252


def test_a_wide_lens_gets_all_eight_terms():
    fit = fit_camera(seen(), SIZE)
    assert len(fit.judged.solution.parameters) == 12 and not fit.judged.outliers
    assert any(fit.camera.distortion[5:]) and set(fit.camera.std) >= {"k4", "k5", "k6"}
    assert fit.judged.solution.rms < 2 * NOISE_PX
    assert np.sqrt((off(fit.camera) ** 2).mean()) < 0.1
    # what it says of itself is of the size of what it is off, where boards were seen; 3 px in the corners, where not
    known = fit.uncertainty
    near = np.hypot(*(known.pixels - 255.5).transpose(2, 0, 1)) < 250
    assert 0.3 < np.sqrt((off(fit.camera) ** 2).mean() / (known.sigma_px[near] ** 2).mean()) < 3


@pytest.mark.parametrize("seed", [1, 2])
def test_a_usual_lens_keeps_its_three(seed):
    assert not is_rational(views(20, 0.1, seed), (640, 480))
