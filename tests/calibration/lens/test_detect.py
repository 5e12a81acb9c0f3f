"""Corners in rendered pictures: where they truly are, in dim and speckled light, and not where there is no board."""

import cv2
import numpy as np
import pytest
from rendered_boards import SIZE, pattern, picture, poses, project

from fusion.calibration.lens.boards.board import Board, board_of
from fusion.calibration.lens.boards.charuco import find_charuco
from fusion.calibration.lens.boards.detect import find_checkerboard, largest_board, stretched
from fusion.calibration.lens.boards.grid import upright
from fusion.errors import FusionError, RecordingError
from fusion.files.content import Content
from fusion.files.json_values import json_values

BOARD = Board(9, 6, 0.04)
CHARUCO = Board(7, 5, 0.05, 0.035, "DICT_5X5_100")


def content(fields):
    return Content(fields, "board.json", "the board", RecordingError)


# the dim one has a 25th of the light: its white squares stand 15 noise levels above the black ones
@pytest.mark.parametrize(("light", "limit"), [(1.0, 0.1), (0.04, 0.2)])
def test_corners_are_found_to_a_fraction_of_a_pixel(light, limit):
    errors = []
    for i, pose in enumerate(poses(3, 12)):
        found = find_checkerboard(picture(BOARD, pose, seed=i, light=light), BOARD)
        assert found is not None
        errors.append(found.pixels - upright(project(BOARD.points(), pose), BOARD))
    assert np.sqrt(np.square(errors).sum(axis=-1).mean()) < limit
    # no shift of half a pixel or a quarter: 162 corners of 0.2 px average to 0.016
    assert (np.abs(np.mean(errors, axis=(0, 1))) < 0.05).all()


def test_glare_moves_no_corner_far():
    pose = poses(1, 12)[0]
    image = picture(BOARD, pose)
    true = upright(project(BOARD.points(), pose), BOARD)
    u, v = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    spot = np.exp(-((u - true[20, 0] - 9) ** 2 + (v - true[20, 1] - 6) ** 2) / 2 / 3**2)
    found = find_checkerboard(np.clip(image + 40000 * spot, 0, 65535).astype(np.uint16), BOARD)
    assert found is not None
    off = np.linalg.norm(found.pixels - true, axis=1)
    assert np.median(off) < 0.1
    assert np.sort(off)[-9] < 0.5  # all but those in the glare itself


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((424, 512), np.uint16),
        np.full((424, 512), 65535, np.uint16),
        np.full((424, 512), np.nan, np.float32),
        np.zeros((1, 1), np.uint16),
        np.zeros((2, 3000), np.uint8),
        np.random.default_rng(0).integers(0, 65535, (60, 80)).astype(np.uint16),
    ],
    ids=["black", "white", "nan", "one pixel", "a line", "noise"],
)
def test_no_board_is_none(image):
    assert find_checkerboard(image, BOARD) is None
    assert find_charuco(image, CHARUCO) is None


def test_pixels_that_are_not_finite_do_not_hide_the_board():
    image = picture(BOARD, poses(1, 12)[0]).astype(np.float32)
    image[::7, ::5] = np.nan
    image[0, 0] = np.inf
    assert np.max(stretched(image)) == 255


def test_huge_pictures_are_searched_small_and_refined_large():
    flat = np.pad(pattern(BOARD), 200, constant_values=120)
    image = np.kron(flat, np.ones((5, 5), np.float32)).astype(np.uint8)  # 4000 px wide
    found = find_checkerboard(image, BOARD)
    assert found is not None
    # corner (0, 0): padding, margin, one square; between two pixels, so half a pixel back
    first = (200 + 20 + 40) * 5 - 0.5
    np.testing.assert_allclose(found.pixels[0], [first, first], atol=0.1)


def test_the_largest_board_in_a_picture_is_counted():
    pose = np.array([0.2, -0.25, 0.1, -0.16, -0.1, 0.5])
    assert sorted(largest_board(picture(BOARD, pose)) or ()) == [6, 9]


def test_no_board_is_counted_where_there_is_none():
    rng = np.random.default_rng(0)
    for blur in (1.5, 3.0, 5.0):  # in each of four or more a grid of four by three is found by OpenCV
        rooms = [cv2.GaussianBlur(rng.normal(size=(240, 320)), (0, 0), blur) for _ in range(4)]
        assert [largest_board(room - room.min()) for room in rooms] == [None] * 4


def test_charuco_corners_are_found_even_when_half_is_hidden():
    board = board_of(content(json_values(CHARUCO.file())))
    pose = np.array([0.2, -0.25, 0.1, -0.2, -0.15, 0.6])
    image = picture(board, pose)
    true = project(board.points(), pose)
    whole = find_charuco(image, board)
    assert whole is not None
    assert len(whole.ids) == board.corners
    assert np.sqrt(((whole.pixels - true[whole.ids]) ** 2).sum(axis=1).mean()) < 0.15
    image[:, int(true[:, 0].mean()) :] = 0
    part = find_charuco(image, board)
    assert part is not None
    assert 6 <= len(part.ids) < board.corners
    assert np.sqrt(((part.pixels - true[part.ids]) ** 2).sum(axis=1).mean()) < 0.15


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"columns": 2}, "from 3 to 60"),
        ({"columns": 1e9}, "whole number"),
        ({"rows": 5.5}, "whole number"),
        ({"rows": "6"}, "whole number"),
        ({"rows": True}, "whole number"),
        ({"rows": float("nan")}, "whole number"),
        ({"square_m": 40}, "millimetres"),
        ({"square_m": 0}, "0.002 to 0.5"),
        ({"square_m": -0.04}, "0.002 to 0.5"),
        ({"square_m": float("nan")}, "0.002 to 0.5"),
        ({"square_m": 1e-6}, "0.002"),
        ({"square_m": 10**400}, "0.002 to 0.5"),
        ({"square_m": None}, "0.002 to 0.5"),
        ({"square_m": [0.04, 0.05]}, "same pitch"),
        ({"square_x_m": 0.04, "square_y_m": 0.05}, "same pitch"),
        ({"marker_m": 0.05, "dictionary": "DICT_5X5_100"}, "less than the squares"),
        ({"marker_m": 0.02, "dictionary": "DICT_NONE"}, "DICT_5X5_100"),
        ({"marker_m": 0.02}, "DICT_5X5_100"),
        ({"marker_m": 0.02, "dictionary": "DICT_4X4_50", "columns": 20, "rows": 20}, "at least 220"),
    ],
)
def test_boards_that_cannot_be_are_refused_in_one_line(change, said):
    with pytest.raises(FusionError, match="cannot be used") as caught:
        board_of(content({"columns": 9, "rows": 6, "square_m": 0.04} | change))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
