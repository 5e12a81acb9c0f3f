"""Following a camera: drift-free against the true surface, frames lost with a reason, found again."""

import numpy as np
import pytest
from small_room import CAMERA, SIGMA, sway

from fusion.geometry.depth import point_map
from fusion.geometry.pose import angle, exp, inverse
from fusion.tracking.tracker import Tracker


def errors(tracked, truth):
    """(n, 2) rad and m."""
    difference = [inverse(T) @ t.T_world_camera for t, T in zip(tracked, truth, strict=True)]
    return np.array([(angle(d), np.linalg.norm(d[:3, 3])) for d in difference])


def blank():
    return point_map(np.full(CAMERA.shape, np.nan, np.float32), CAMERA, SIGMA)


def test_a_swaying_camera_is_followed(room):
    truth = [sway(t) for t in np.arange(12) * 0.15]
    tracker = Tracker(room.model)
    tracked = [tracker.place(room.frame(T, seed)) for seed, T in enumerate(truth)]
    assert all(t.ok for t in tracked)
    # 3000 pixels of 2 mm noise that act on six unknowns: about 0.1 mm and 0.1 mrad; five times that for the nearest
    # pixels that stand for the model, one pixel being 1 cm wide
    found = errors(tracked, truth)
    assert found[:, 0].max() < 0.5e-3
    assert found[:, 1].max() < 0.5e-3
    assert tracked[0].T_world_camera == pytest.approx(np.eye(4))


def test_a_model_that_is_the_same_is_looked_at_once(room):
    truth = [sway(t) for t in np.arange(6) * 0.15]
    looks = []
    tracker = Tracker(lambda T: looks.append(T) or room.model(T))
    tracked = [tracker.place(room.frame(T, seed), same=seed % 3 > 1) for seed, T in enumerate(truth)]
    assert len(looks) == 3
    assert errors(tracked, truth).max() < 0.5e-3


def test_the_first_frame_with_a_surface_is_the_world(room):
    tracker = Tracker(room.model)
    first = tracker.place(blank())
    assert first.status == "only 0 pixels show a surface"
    assert np.isnan(first.T_world_camera).all()
    assert tracker.place(room.frame(np.eye(4), 0)).T_world_camera == pytest.approx(np.eye(4))


@pytest.mark.parametrize("what", ["blank", "another scene"])
def test_a_lost_frame_has_a_reason_and_the_next_is_found(room, wall, what):
    truth = [sway(t) for t in np.arange(8) * 0.15]
    bad = {3, 4}
    tracker = Tracker(room.model)
    tracked = []
    for i, T in enumerate(truth):
        # 0.5 m from a wall: no pose near the last one looks like that
        wrong = blank() if what == "blank" else wall.frame(exp([0, 0, 0, 0, 0, 0.7]), i)
        tracked.append(tracker.place(wrong if i in bad else room.frame(T, i)))
    assert {i for i, t in enumerate(tracked) if not t.ok} == bad
    assert all("pixels" in tracked[i].status or "fit" in tracked[i].status or "met" in tracked[i].status for i in bad)
    good = [i for i in range(len(truth)) if i not in bad]
    assert errors([tracked[i] for i in good], [truth[i] for i in good]).max() < 0.5e-3


def test_a_camera_that_comes_back_is_found_from_an_older_pose(room):
    """Lost on the far side, then back where it was once: too far from the last good pose, near an older one."""
    out = [exp([0, 0.05 * i, 0, -0.05 * i, 0, 0]) for i in range(9)]
    tracker = Tracker(room.model)
    for i, T in enumerate(out):
        assert tracker.place(room.frame(T, i)).ok
    assert not tracker.place(blank()).ok
    back = tracker.place(room.frame(exp([0, 0.02, 0, 0, 0, 0.01]), 99))
    assert back.ok
    assert errors([back], [exp([0, 0.02, 0, 0, 0, 0.01])]).max() < 0.5e-3


def test_a_jump_is_not_taken_for_motion(room):
    tracker = Tracker(room.model)
    tracker.place(room.frame(np.eye(4), 0))
    jumped = tracker.place(room.frame(exp([0, 0.9, 0, 0, 0, 0]), 1))
    assert not jumped.ok
    assert tracker.place(room.frame(np.eye(4), 2)).ok


def test_a_long_run_stays_rigid(room):
    """Rounding errors of poses multiplied into each other must not grow."""
    tracker = Tracker(room.model)
    for i in range(60):
        last = tracker.place(room.frame(exp([0, 0.002 * np.sin(i), 0, 0.002 * i, 0, 0]), i))
    R = last.T_world_camera[:3, :3]
    assert np.abs(R @ R.T - np.eye(3)).max() < 1e-12


def test_a_plane_alone_reports_what_it_does_not_fix(wall):
    tracker = Tracker(wall.model)
    tracker.place(wall.frame(np.eye(4), 0))
    tracked = tracker.place(wall.frame(exp([0, 0, 0, 0.01, 0, 0.01]), 1))
    assert tracked.ok
    assert set(tracked.unconstrained) == {"rotation z", "shift x", "shift y"}
