"""Rigid poses form a group; the names say what they do."""

import numpy as np
import pytest

from fusion.geometry.pose import about_axis, angle, exp, from_tum, inverse, is_rigid, pose, to_tum, transform

# double precision over a few products of numbers near 1
TIGHT = 1e-12


def random_poses(count: int, seed: int) -> np.ndarray:
    """(count, 4, 4) poses with every rotation angle up to pi and shifts of a few metres."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(count, 3))
    turns = axes / np.linalg.norm(axes, axis=1, keepdims=True) * rng.uniform(0, np.pi, (count, 1))
    return np.array([exp(xi) for xi in np.hstack([turns, rng.normal(scale=2, size=(count, 3))])])


@pytest.fixture(params=range(20))
def three(request) -> np.ndarray:
    return random_poses(3, seed=request.param)


def test_product_is_a_pose_and_associative(three):
    a, b, c = three
    assert is_rigid(a @ b, TIGHT)
    np.testing.assert_allclose((a @ b) @ c, a @ (b @ c), atol=TIGHT)


def test_identity_and_inverse(three):
    a, b, _ = three
    np.testing.assert_allclose(exp(np.zeros(6)), np.eye(4), atol=0)
    np.testing.assert_allclose(a @ inverse(a), np.eye(4), atol=TIGHT)
    np.testing.assert_allclose(inverse(a) @ a, np.eye(4), atol=TIGHT)
    np.testing.assert_allclose(inverse(a @ b), inverse(b) @ inverse(a), atol=TIGHT)


def test_inverse_of_a_stack_is_that_of_each(three):
    np.testing.assert_array_equal(inverse(three), [inverse(T) for T in three])


def test_transform_follows_the_product_and_keeps_distances(three):
    a, b, _ = three
    points = np.random.default_rng(0).normal(size=(5, 7, 3))
    np.testing.assert_allclose(transform(a @ b, points), transform(a, transform(b, points)), atol=TIGHT)
    before, after = np.diff(points, axis=1), np.diff(transform(a, points), axis=1)
    np.testing.assert_allclose(np.linalg.norm(after, axis=-1), np.linalg.norm(before, axis=-1), atol=TIGHT)


def test_exp_is_a_turn_about_the_origin_then_a_shift(three):
    xi = np.random.default_rng(1).normal(size=6)
    np.testing.assert_allclose(exp(xi), exp([0, 0, 0, *xi[3:]]) @ exp([*xi[:3], 0, 0, 0]), atol=TIGHT)


@pytest.mark.parametrize("turn", [0.0, 1e-9, 0.3, np.pi / 2, 3.0, np.pi])
def test_angle_is_what_was_turned(turn):
    T = about_axis([1.0, -2.0, 0.5], [0.2, 3.0, -1.0], turn)
    # near pi the angle's derivative is lost in rounding: sqrt of double precision
    assert angle(T) == pytest.approx(turn, abs=1e-7)


def test_turning_about_an_axis_keeps_its_points_and_adds_angles():
    point, direction = np.array([0.1, -0.2, 0.8]), np.array([0.1, -1.0, 0.2])
    T = about_axis(point, direction, 0.7)
    on_axis = point + np.linspace(-2, 2, 5)[:, None] * direction
    np.testing.assert_allclose(transform(T, on_axis), on_axis, atol=TIGHT)
    np.testing.assert_allclose(T @ about_axis(point, direction, 0.4), about_axis(point, direction, 1.1), atol=TIGHT)


def test_turning_is_right_handed():
    quarter = about_axis([0, 0, 0], [0, 0, 1], np.pi / 2)
    np.testing.assert_allclose(transform(quarter, np.array([1.0, 0, 0])), [0, 1, 0], atol=TIGHT)


def test_tum_round_trip(three):
    for T in three:
        np.testing.assert_allclose(from_tum(to_tum(T)), T, atol=TIGHT)
        assert to_tum(T)[6] >= 0
        np.testing.assert_allclose(np.linalg.norm(to_tum(T)[3:]), 1, atol=TIGHT)


def test_tum_is_scalar_last():
    half_turn_about_x = pose(np.diag([1.0, -1.0, -1.0]), [1, 2, 3])
    np.testing.assert_allclose(np.abs(to_tum(half_turn_about_x)), [1, 2, 3, 1, 0, 0, 0], atol=TIGHT)


@pytest.mark.parametrize(
    "T",
    [
        np.zeros((4, 4)),
        np.full((4, 4), np.nan),
        np.diag([1.0, 1.0, -1.0, 1.0]),  # a mirror
        np.diag([1.1, 1.1, 1.1, 1.0]),  # a scale
        np.eye(3),
        np.eye(4) + np.eye(4, k=-3),  # a last row that is not 0 0 0 1
    ],
)
def test_what_is_not_rigid_is_told(T):
    assert not is_rigid(T)


@pytest.mark.parametrize("column", range(4))
def test_a_matrix_with_another_last_row_is_no_pose(column):
    T = random_poses(1, 5)[0]
    T[3, column] += 0.01
    assert not is_rigid(T)
