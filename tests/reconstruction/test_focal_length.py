"""Landmarks tell a focal length that is wrong, by their own noise no other one, and nothing where they cannot."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse, pose, transform
from fusion.reconstruction.focal_length import FocalSeen, focal_of, focal_seen
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.settings import ReconstructSettings
from fusion.tracking.landmarks import Landmarks
from reference.walked_room import WalkedRoom, round_walk

CAMERA = Camera(320, 240, 290.0, 290.0, 159.5, 119.5)
VIEWS, STEP = 14, 9.0  # [deg] between them


def seen(relative, noise=0.0, views=VIEWS, step=STEP):
    """Landmarks of a cloud 2 m before cameras that walk round it, by a camera whose fx is that much smaller than right.

    Args:
        noise: standard deviation [m] of where a landmark lies across the view; three times that along it.
    """
    rng = np.random.default_rng(3)
    cloud = rng.uniform(-0.6, 0.6, (150, 3))
    names = rng.integers(0, 256, (150, 32), np.uint8)
    middle = np.eye(4)
    middle[2, 3] = 2.0
    poses = np.stack(
        [
            inverse(middle @ pose(Rotation.from_euler("y", k * step, degrees=True).as_matrix(), np.zeros(3)))
            for k in range(views)
        ]
    )
    shown = []
    for T in poses:
        points = transform(inverse(T), cloud) + rng.normal(0, 1, (150, 3)) * noise * [1, 1, 3]
        points[:, :2] *= 1 + relative
        shown.append(Landmarks(points, np.hypot(1.5 * points[:, 2] / 290, max(3 * noise, 1e-3)), names))
    return shown, poses


def told(shown, poses):
    return focal_seen(shown, poses, CAMERA.fx)


@pytest.mark.parametrize("relative", [-0.08, 0.0, 0.03])
def test_it_is_told(relative):
    found = told(*seen(relative, noise=0.002))
    assert found.relative == pytest.approx(relative, abs=0.1 * abs(relative) + 4 * found.std)
    assert 1e-5 < found.std < 2e-3


def test_noise_of_landmarks_is_no_focal_length():
    """Noise in both sides of the equation would make it more than 1 % here."""
    assert told(*seen(0.0, noise=0.012)).relative == pytest.approx(0, abs=0.004)


def test_what_is_said():
    right, wrong, far = (told(*seen(e, noise=0.002)).light(CAMERA) for e in (0.0, 0.018, -0.05))
    assert [light.level for light in (right, wrong, far)] == ["ok", "warning", "bad"]
    assert "fx 275.0 instead of 290.0 px (-5.2 +- 0.5 %)" in far.reason


def test_a_camera_that_states_its_doubt_is_believed():
    found = told(*seen(0.018, noise=0.002))
    assert found.light(CAMERA).level == "warning"
    assert found.light(replace(CAMERA, std={"fx": 2.9})) is None


def test_a_walk_with_a_wrong_camera():
    recording = WalkedRoom().recording(round_walk(2.0))
    right = recording.camera.fx
    camera = replace(recording.camera, fx=0.94 * right, fy=0.94 * recording.camera.fy)
    result = reconstruct(replace(recording, camera=camera), ReconstructSettings(voxel=0.02, truncation=0.08))
    (light,) = [light for light in result.judgement.lights if light.subject == "Camera"]
    said = float(re.search(r"only with fx ([0-9.]+) instead", light.reason)[1])
    assert light.level == "bad" and said == pytest.approx(right, rel=0.03)
    assert result.sure.common.told_by == "scan" and result.sure.common.focal > 0.04  # and every vertex says so


def test_vague_agreement_is_not_praised():
    assert FocalSeen(0.02, 0.012, 20).light(CAMERA) is None
    assert FocalSeen(0.08, 0.012, 20).light(CAMERA).level == "bad"


def test_views_of_one_side_say_nothing():
    assert told(*seen(0.05, step=1.0)) is None
    assert told(*seen(0.05, views=3)) is None
    shown, poses = seen(0.05)
    assert told([None] * VIEWS, poses) is None
    assert told(shown, np.full_like(poses, np.nan)) is None
    assert focal_of([], poses) is None
