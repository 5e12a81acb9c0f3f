"""The fit of a camera: true to its own intervals, blind to wrong views, strict about the board."""

import cv2
import numpy as np
import pytest
from rendered_boards import SIZE, TRUTH, poses, project, views

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.grid import upright
from fusion.calibration.lens.fit.outliers import judge
from fusion.calibration.lens.fit.solve import NAMES, matrix, residual, solve
from fusion.calibration.lens.fit.spread import jacobian, spread
from fusion.calibration.lens.fit.usual import unusual
from fusion.calibration.lens.intrinsics import fit_camera
from fusion.calibration.lens.pair import place_color
from fusion.calibration.lens.uncertainty import projection_uncertainty
from fusion.calibration.lens.views import view_of
from fusion.errors import FusionError

BOARD = Board(9, 6, 0.04)


def test_parameters_lie_within_their_standard_deviations():
    z = []
    for seed in range(8):
        seen = views(15, 0.1, seed)
        solution = solve(seen, SIZE)
        z.append((solution.parameters - TRUTH) / spread(seen, solution).std)
    # 8 x 9 numbers of variance 1, correlated within a seed: their mean square is within 1 +- 0.5 in 19 of 20 cases; the
    # widening by the jackknife makes it smaller, never larger
    assert 0.3 < np.mean(np.square(z)) < 1.6


def test_many_pictures_of_one_view_are_told_as_such():
    rng, exact = np.random.default_rng(2), [project(BOARD.points(), pose) for pose in poses(3, 2)]

    def still(of: list[np.ndarray], count: int) -> list:
        return [view_of(f"{i}", of[i % len(of)] + rng.normal(0, 0.1, of[0].shape), BOARD) for i in range(count)]

    with pytest.raises(FusionError, match=r"too few different views.*20 pictures of a single view"):
        fit_camera(still(exact[:1], 20), SIZE)
    with pytest.raises(FusionError, match=r"too few different views.*20 pictures of 2 views"):
        fit_camera(still(exact[:2], 20), SIZE)
    assert len(fit_camera(still(exact, 20), SIZE).judged.views) == 20


def test_the_jacobian_is_the_derivative():
    view = views(1, 0.0)[0]
    pose = np.array([0.1, -0.2, 0.05, -0.1, -0.1, 0.9])
    J, r = jacobian(view, pose, TRUTH)
    for column, step in enumerate([1e-3] * 4 + [1e-5] * 5):
        moved = TRUTH.copy()
        moved[column] += step
        numeric = -(residual(view, pose, moved).ravel() + r) / step
        # a one-sided difference: its error is of the order of the step times the second derivative
        np.testing.assert_allclose(J[:, column], numeric, rtol=1e-3, atol=1e-2)


def test_leaving_out_a_view_is_what_solving_without_it_gives():
    seen = views(12, 0.1, 3)
    solution = solve(seen, SIZE)
    known = spread(seen, solution)
    without = solve(seen[1:], SIZE, solution.parameters)
    # linearised: the shift is right to a tenth of a standard deviation
    np.testing.assert_allclose(
        (without.parameters - solution.parameters) / known.std, known.shifts[0] / known.std, atol=0.1
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_wrong_views_are_named_and_only_those(seed):
    seen = views(20, 0.08, seed)
    rng = np.random.default_rng(seed)
    # corners counted from the wrong place, a bent board, a blurred one
    seen[3] = view_of("03", np.roll(seen[3].pixels, 2, axis=0), BOARD)
    bend = 3.0 * (BOARD.points()[:, 0] / BOARD.points()[:, 0].max() - 0.5) ** 2
    seen[7] = view_of("07", seen[7].pixels + bend[:, None] * [0, 1], BOARD)
    seen[11] = view_of("11", seen[11].pixels + rng.normal(0, 0.6, (54, 2)), BOARD)
    judged = judge(seen, SIZE)
    assert [outlier.name for outlier in judged.outliers] == ["03", "07", "11"]
    known = spread(judged.views, judged.solution)
    # 4 standard deviations: none of nine numbers reaches them by chance
    assert (np.abs(judged.solution.parameters - TRUTH) < 4 * known.std).all()


def test_good_views_have_no_outliers_and_single_wild_corners_do_not_spoil_a_view():
    seen = views(15, 0.08, 5)
    assert judge(seen, SIZE).outliers == []
    pixels = seen[4].pixels.copy()
    pixels[10] += [1.5, -1.0]
    seen[4] = view_of("04", pixels, BOARD)
    judged = judge(seen, SIZE)
    assert judged.outliers == []
    assert judged.wild == {"04": 1}


def test_outliers_can_be_kept():
    seen = views(12, 0.08, 2)
    seen[5] = view_of("05", seen[5].pixels + np.random.default_rng(0).normal(0, 1, (54, 2)), BOARD)
    kept = judge(seen, SIZE, keep=True)
    assert [outlier.name for outlier in kept.outliers] == ["05"]
    assert len(kept.views) == 12


def test_views_that_contradict_each_other_are_refused():
    rng = np.random.default_rng(0)
    seen = [
        view_of(str(i), rng.uniform(0, 400, (54, 2)) if i % 2 else view.pixels, BOARD)
        for i, view in enumerate(views(12, 0.1))
    ]
    with pytest.raises(FusionError, match=r"contradict|explains"):
        judge(seen, SIZE)


def test_one_view_is_too_few_and_flat_ones_leave_the_camera_open():
    with pytest.raises(FusionError, match="too few"):
        fit_camera(views(1, 0.1), SIZE)
    rng = np.random.default_rng(0)
    flat = [
        project(BOARD.points(), np.array([0, 0, 0, -0.2 + 0.02 * i, -0.1, 0.9])) + rng.normal(0, 0.1, (54, 2))
        for i in range(6)
    ]
    # frontal boards tell the focal length only through the lens
    with pytest.raises(FusionError, match=r"open|explains|not square"):
        fit_camera([view_of(str(i), pixels, BOARD) for i, pixels in enumerate(flat)], SIZE)


def noisy(parameters, seed):
    """Ten views of the board with a tenth of a pixel of noise."""
    rng = np.random.default_rng(seed)
    return [
        view_of(f"{i}", project(BOARD.points(), pose, parameters) + rng.normal(0, 0.1, (54, 2)), BOARD)
        for i, pose in enumerate(poses(10, 6))
    ]


def test_an_unseen_k3_is_held_and_an_established_one_is_kept():
    plain = TRUTH.copy()
    plain[4:] = [0.05, 0.0, 0, 0, 0]
    fit = fit_camera(noisy(plain, 1), SIZE)
    assert fit.k3_held
    assert fit.camera.distortion[4] == 0
    # how well it would be known: as it scatters over other noise, of which 12 draws tell the size to a fifth
    scatter = np.std([solve(noisy(plain, seed), SIZE).parameters[8] for seed in range(2, 14)])
    assert fit.camera.std["k3"] == pytest.approx(scatter, rel=0.6)
    strong = TRUTH.copy()
    strong[8] = 0.6
    seen = [view_of(f"{i}", project(BOARD.points(), pose, strong), BOARD) for i, pose in enumerate(poses(10, 6))]
    assert fit_camera(seen, SIZE).camera.distortion[4] == pytest.approx(0.6, abs=0.01)  # no noise: only rounding


def test_uncertainty_grows_away_from_the_corners_and_with_distance():
    fit = fit_camera(views(12, 0.1, 1), SIZE)
    numbers = fit.uncertainty.numbers()
    assert numbers["centre_px"] < numbers["rms_px"] < numbers["worst_px"]
    assert numbers["centre_mm"] == pytest.approx(numbers["centre_px"] * numbers["distance_m"] / 366.5 * 1000, rel=0.02)


@pytest.mark.slow
def test_the_projection_uncertainty_is_that_of_repeated_calibrations():
    """Where fixed rays are seen by ten cameras from the same views with new noise, the cameras' turns taken out."""
    clean = views(10, 0.0, 77)
    errors, predicted = [], None
    for seed in range(10):
        rng = np.random.default_rng(seed)
        seen = [view_of(v.name, v.pixels + rng.normal(0, 0.1, v.pixels.shape), BOARD) for v in clean]
        solution = solve(seen, SIZE)
        known = spread(seen, solution)
        camera = solution.camera(SIZE)
        predicted = predicted or projection_uncertainty(camera, known.covariance, 1.0)
        rays = np.hstack([camera.rays()[207, 100:400:50].astype(float), np.ones((6, 1))])
        off, J = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix(TRUTH), TRUTH[4:])
        left = (off.reshape(-1, 2) - np.stack([np.arange(100, 400, 50), np.full(6, 207)], axis=1)).ravel()
        errors.append(left - J[:, :3] @ np.linalg.lstsq(J[:, :3], left, rcond=None)[0])
    rms = np.sqrt(np.mean(np.square(errors)))
    row = predicted.sigma_px[6, 3:13]  # the same part of the picture
    # the turn is fitted to six rays in one row here and to the whole picture there: alike to a factor of two
    assert 0.3 < rms / np.sqrt(np.mean(row**2)) < 1.5


def test_the_colour_camera_is_placed_beside_the_other():
    T = np.eye(4)
    T[:3, :3] = cv2.Rodrigues(np.array([0.01, -0.02, 0.005]))[0]
    T[:3, 3] = [-0.052, 0.003, -0.002]
    rng = np.random.default_rng(3)
    ir, color = [], []
    for i, pose in enumerate(poses(12, 8)):
        R = T[:3, :3] @ cv2.Rodrigues(pose[:3])[0]
        other = np.concatenate([cv2.Rodrigues(R)[0].ravel(), T[:3, :3] @ pose[3:] + T[:3, 3]])
        ir.append(view_of(f"{i}", project(BOARD.points(), pose) + rng.normal(0, 0.1, (54, 2)), BOARD))
        color.append(view_of(f"{i}", project(BOARD.points(), other) + rng.normal(0, 0.1, (54, 2)), BOARD))
    color[4] = view_of("4", color[4].pixels[::-1], BOARD)  # counted from the other end
    camera = solve(ir, SIZE, TRUTH).camera(SIZE)
    pair = place_color(ir, color, camera, solve(color[:4] + color[5:], SIZE, TRUTH).camera(SIZE))
    assert pair.left_out == ["4"]
    # 0.1 px at 0.9 m and 366 px is 0.25 mm a corner; over 11 pairs of 54 corners, and the two cameras' own errors
    np.testing.assert_allclose(pair.T_color_depth[:3, 3], T[:3, 3], atol=0.003)
    np.testing.assert_allclose(pair.T_color_depth[:3, :3], T[:3, :3], atol=0.005)


def test_corners_are_counted_alike_from_either_end():
    pixels = project(BOARD.points(), np.array([0.1, 0.2, 0.3, -0.2, -0.1, 0.9]))
    for other in (pixels[::-1], pixels.reshape(6, 9, 2)[:, ::-1].reshape(-1, 2)):
        np.testing.assert_array_equal(upright(other, BOARD), upright(pixels, BOARD))


def test_names_are_in_the_order_of_opencv():
    assert NAMES == ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


def told_unusual(seen):
    solution = solve(seen, SIZE)
    return unusual(solution, spread(seen, solution).covariance, SIZE)


def test_a_camera_like_no_other_is_told():
    seen = views(15, 0.1, 1)
    assert told_unusual(seen) == []
    stretched = [view_of(v.name, v.pixels * [1, 1.06], BOARD) for v in seen]
    (said,) = told_unusual(stretched)
    assert "fx and fy differ by 6.1%" in said and "middle" not in said
    cut = [view_of(v.name, v.pixels - [0.2 * SIZE[0], 0], BOARD) for v in seen]
    (said,) = told_unusual(cut)
    assert "cx is" in said and "differ" not in said
