"""Boards that are not what board.json says: uneven prints, boards that bow."""

import numpy as np
import pytest
from rendered_boards import SIZE, TRUTH, poses, project, views

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.fit.joint import board_shape, check_pitch
from fusion.calibration.lens.fit.solve import jacobian, residual, solve
from fusion.calibration.lens.fit.spread import spread
from fusion.calibration.lens.intrinsics import fit_camera
from fusion.calibration.lens.views import view_of
from fusion.errors import FusionError

BOARD = Board(9, 6, 0.04)


def seen(points: np.ndarray, seed: int = 0, count: int = 15):
    """Views of a board whose corners lie at `points` and not where BOARD says."""
    rng = np.random.default_rng(seed)
    return [
        view_of(f"{i}", project(points, pose) + rng.normal(0, 0.1, (54, 2)), BOARD)
        for i, pose in enumerate(poses(count, seed + 4))
    ]


def bowed(height: float, turn: float = 0.0) -> np.ndarray:
    """Corners (54, 3) on a cylinder that rises by `height` [m] over half the longer side; its axis turned [rad]."""
    points = BOARD.points()
    x, y = ((points[:, :2] - points[:, :2].mean(axis=0)) / 0.16).T
    points[:, 2] = height * (x * np.cos(turn) + y * np.sin(turn)) ** 2
    return points


def off(fit) -> np.ndarray:
    """(4,) fx, fy, cx, cy minus the truth, in the fit's own standard deviations."""
    camera = fit.camera
    return np.array(
        [(getattr(camera, n) - t) / camera.std[n] for n, t in zip(("fx", "fy", "cx", "cy"), TRUTH[:4], strict=True)]
    )


@pytest.mark.parametrize(("height", "turn"), [(0.003, 0.0), (-0.003, 0.6), (0.012, 1.2)])
def test_a_board_that_bows_is_told_and_does_not_spoil_the_camera(height, turn):
    points = bowed(height, turn)
    fit = fit_camera(seen(points), SIZE)
    bow, std = fit.shape.bow
    assert abs(bow - np.ptp(points[:, 2])) < 4 * std < 0.0005  # [m]
    (said,) = fit.shape.warnings()
    assert f"bows by {1000 * bow:.1f} +-" in said
    # four numbers: 4 standard deviations are not reached by chance
    assert (np.abs(off(fit)) < 4).all()
    assert fit.camera.std["fx"] < 0.005 * TRUTH[0]
    assert fit.judged.outliers == []


def test_the_standard_deviations_hold_where_the_board_bows():
    z = np.array([off(fit_camera(seen(bowed(0.003, seed), seed), SIZE)) for seed in range(8)])
    # as in test_lens_fit: 19 of 20 cases within 1 +- 0.5, less where the jackknife widens
    assert 0.2 < np.mean(z**2) < 1.6


@pytest.mark.parametrize(("ratio", "wider"), [(0.99, "columns"), (1.01, "rows")])
def test_an_uneven_print_is_told_and_does_not_spoil_the_camera(ratio, wider):
    fit = fit_camera(seen(BOARD.points() * [1, ratio, 1]), SIZE)
    assert abs(fit.shape.pitch[0] - ratio) < 4 * fit.shape.pitch[1] < 0.004
    (said,) = fit.shape.warnings()
    assert f"the board's {wider} are further apart" in said
    assert (np.abs(off(fit)) < 4).all()


def test_a_very_uneven_board_is_refused_and_an_even_one_is_not():
    flat = seen(BOARD.points() * [1, 1.05, 1])
    shape, _ = board_shape(flat, solve(flat, SIZE))
    ratio, std = shape.pitch
    assert abs(ratio - 1.05) < 5 * std
    assert std < 0.005
    with pytest.raises(FusionError, match="not square"):
        fit_camera(flat, SIZE)
    fit = fit_camera(views(15, 0.1, 4), SIZE)
    check_pitch(*fit.shape.pitch)
    assert fit.shape.warnings() == []


def test_the_shape_s_columns_are_the_derivative():
    flat = views(6, 0.1, 2)
    shape, solution = board_shape(flat, solve(flat, SIZE))
    view, pose, camera = flat[0], solution.poses[0], solution.parameters
    J, r = shape.jacobian(shape.on(view), pose, camera)
    plain, same = jacobian(shape.on(view), pose, camera)
    np.testing.assert_array_equal(np.delete(J, range(9, 13), axis=1), plain)
    np.testing.assert_array_equal(r, same)
    assert np.abs(shape.terms[1:]).max() < 0.01
    for term in range(4):
        step = np.eye(4)[term] * 1e-5
        moved = type(shape)(shape.centre, shape.half, shape.aspect, shape.terms + step, shape.weight, shape.covariance)
        numeric = -(residual(moved.on(view), pose, camera).ravel() + r) / 1e-5
        # one-sided, and the place on the board is that of the stretched point: a share of the terms
        np.testing.assert_allclose(J[:, 9 + term], numeric, rtol=0.02, atol=0.02 * np.abs(numeric).max())


def test_a_flat_even_board_is_taken_as_one():
    flat = views(15, 0.1, 4)
    fit = fit_camera(flat, SIZE)
    # the camera is that of the flat board to the last digits, its standard deviations are not
    plain = solve(flat, SIZE, hold_k3=fit.k3_held)
    np.testing.assert_allclose(fit.judged.solution.parameters, plain.parameters, rtol=1e-4, atol=1e-5)
    assert (fit.spread.scatter > spread(flat, solve(flat, SIZE)).scatter).all()
