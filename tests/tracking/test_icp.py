"""Alignment of point maps: exact where it can be, honest where it cannot."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_room import CAMERA, SIGMA

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import angle, exp, inverse
from fusion.tracking.icp import IcpSettings, align


def error(found, true):
    """(rad, m) between two poses."""
    difference = inverse(true) @ found
    return angle(difference), float(np.linalg.norm(difference[:3, 3]))


@pytest.mark.parametrize("seed", range(4))
def test_a_known_motion_is_found(room, seed):
    rng = np.random.default_rng(seed)
    true = exp(np.concatenate([rng.normal(0, 0.02, 3), rng.normal(0, 0.02, 3)]))
    result = align(room.frame(true, seed), room.model(np.eye(4)), np.eye(4))
    turn, shift = error(result.T_model_source, true)
    assert result.ok
    # about 4000 pixels of 2 mm noise average to 0.03 mm; the rest is what normals from noisy depth and the
    # nearest-pixel association of a coarse image leave: at most a fifth of the noise of one pixel
    assert turn < 0.001
    assert shift < 0.2 * SIGMA * 2
    assert result.inlier_share > 0.8


def test_the_information_tells_the_spread_of_the_result(room):
    """Repeated with new noise, the poses scatter as the information says."""
    true = exp([0.01, -0.01, 0.02, 0.01, 0.01, -0.02])
    model = room.model(np.eye(4))
    results = [align(room.frame(true, seed), model, true) for seed in range(12)]
    shifts = np.array([(r.T_model_source @ inverse(true))[:3, 3] for r in results])
    turns = np.array([Rotation.from_matrix((r.T_model_source @ inverse(true))[:3, :3]).as_rotvec() for r in results])
    stated = np.sqrt(np.diag(np.linalg.inv(results[0].information)))
    # twelve samples know their spread to 21 %; pairing and normals share the noise, which may double it
    assert (turns.std(axis=0) < 2.5 * stated[:3]).all()
    assert shifts.std(axis=0).max() < 4 * stated[3:].max()


def test_a_plane_says_what_it_does_not_fix_and_stays_there(wall):
    model = wall.model(np.eye(4))
    guess = exp([0, 0, 0, 0.01, -0.02, 0.0])
    true = exp([0.01, 0, 0, 0.0, 0.0, 0.015])
    result = align(wall.frame(true, 1), model, guess)
    assert result.ok
    assert set(result.unconstrained) == {"rotation z", "shift x", "shift y"}
    # what the plane fixes is found; along it the guess stays, but for what turning about the centroid adds (1.2 m x
    # 0.01 rad in y)
    assert abs(result.T_model_source[2, 3] - true[2, 3]) < 0.002
    assert abs(result.T_model_source[0, 3] - guess[0, 3]) < 0.002


def test_a_room_fixes_everything(room):
    assert align(room.frame(np.eye(4), 1), room.model(np.eye(4)), np.eye(4)).unconstrained == ()


def test_another_surface_does_not_fit(room, wall):
    result = align(wall.frame(np.eye(4), 1), room.model(np.eye(4)), np.eye(4))
    assert not result.ok
    assert "fit the model" in result.status or "met the model" in result.status


def test_without_a_model_nothing_is_met(room):
    nothing = np.full((*CAMERA.shape, 3), np.nan, np.float32)
    model = PointMap(CAMERA, nothing, nothing.copy(), nothing[..., 0].copy())
    result = align(room.frame(np.eye(4)), model, np.eye(4))
    assert result.status == "only 0 points met the model"


def test_outliers_do_not_pull(room):
    """A hand in the picture: a fifth of the frame is 5 cm nearer."""
    true = exp([0.01, 0.01, 0, 0.01, 0, 0.01])
    frame = room.frame(true, 3)
    hand = np.array(frame.points)
    hand[40:80, 60:120] *= 0.95
    result = align(PointMap(CAMERA, hand, frame.normals, frame.sigma), room.model(np.eye(4)), np.eye(4))
    turn, shift = error(result.T_model_source, true)
    assert result.ok
    assert turn < 0.002
    assert shift < 0.002  # one standard deviation of a pixel


def test_a_limit_on_the_residual_is_kept(room):
    result = align(room.frame(np.eye(4), 1), room.model(np.eye(4)), np.eye(4), IcpSettings(max_residual=1e-4))
    assert "is above 0.1 mm" in result.status
