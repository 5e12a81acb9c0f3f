"""Pictures that are not those of one camera, copies, and boards that are hardly tilted: told."""

import cv2
import numpy as np
import pytest
from rendered_boards import SIZE, TRUTH, picture, poses, project, views

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.search import search
from fusion.calibration.lens.fit.alike import unlike
from fusion.calibration.lens.intrinsics import fit_camera
from fusion.calibration.lens.views import view_of

BOARD = Board(9, 6, 0.04)


def told(seen) -> list[str]:
    fit = fit_camera(seen, SIZE)
    return unlike(fit.judged.views, fit.judged.solution, fit.spread.sigma_px)


@pytest.mark.parametrize("seed", range(3))
def test_two_cameras_are_told_and_one_is_not(seed):
    seen = views(16, 0.1, seed)
    assert told(seen) == []
    rng = np.random.default_rng(seed)
    far = TRUTH * [1.05, 1.05, 1, 1, 1, 1, 1, 1, 1]  # the focus moved
    mixed = [
        view_of(f"{i}", project(BOARD.points(), pose, far if i % 2 else TRUTH) + rng.normal(0, 0.1, (54, 2)), BOARD)
        for i, pose in enumerate(poses(16, seed))
    ]
    (said,) = told(mixed)
    assert "not those of one camera" in said and "focal lengths by" in said


def test_every_second_picture_mirrored_is_told():
    seen = views(16, 0.1, 1)
    for i in range(1, 16, 2):  # of a lens that is 5 px further off the middle, as some are
        # counted as a detector does, which takes a mirrored board for one from the other end
        mirrored = (seen[i].pixels * [-1, 1] + [SIZE[0] - 1 - 6, 0]).reshape(6, 9, 2)[:, ::-1].reshape(-1, 2)
        seen[i] = view_of(seen[i].name, mirrored, BOARD)
    (said,) = told(seen)
    assert "cx by" in said


def test_a_copy_of_a_picture_counts_once(tmp_path):
    board = Board(8, 5, 0.05)
    files = {}
    for i, tilt in enumerate((0.3, 0.3, -0.3, 0.1)):
        pose = np.array([tilt, 0.2, 0.0, -0.17, -0.1, 0.55])
        files[f"{i}"] = tmp_path / f"{i}.png"
        cv2.imwrite(str(files[f"{i}"]), picture(board, pose, seed=max(i - 1, 0)))
    found = search(files, board)
    assert [view.name for view in found.views] == ["0", "2", "3"]
    assert found.unread == {"1": "the same picture as 0"}
