"""Poses that are given are held against the depth, and say as well as tracked ones how large a thing they show."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse, pose, rotation
from fusion.geometry.trajectory import Trajectory
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.planning import plan
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.recording import Frame, Recording
from fusion.sensor.presets import default_sensor

CAMERA = Camera(80, 60, 65.0, 65.0, 39.5, 29.5)
COUNT = 24
LOW, HIGH = np.array([-2.1, -1.2, -1.6]), np.array([1.9, 1.3, 1.7])  # [m] walls


def turned():
    """(n, 4, 4) a camera that is carried in a circle and looks outwards."""
    turns = np.arange(COUNT) * 2 * np.pi / COUNT
    return np.stack([pose(rotation(np.array([0, a, 0])), [0.4 * np.sin(a), 0.05 * np.sin(3 * a), 0.4 * np.cos(a)])
                     for a in turns])  # fmt: skip


def seen(T):
    """Depth (h, w) [m] of the walls."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.dstack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)]) @ T[:3, :3].T
    with np.errstate(divide="ignore"):
        return np.where(rays > 0, (HIGH - T[:3, 3]) / rays, (LOW - T[:3, 3]) / rays).min(axis=-1).astype(np.float32)


@pytest.fixture
def room(tmp_path):
    """A recording of a bare room, and the true poses."""
    stamps, poses = np.arange(COUNT) / 10, turned()
    made = Recording(tmp_path, "native", CAMERA, stamps, lambda i: Frame(i, i / 10, seen(poses[i])))
    return made, Trajectory(stamps, poses)


def test_inverted_poses_are_blamed(room):
    recording, true = room
    turned_round = replace(true, poses=inverse(true.poses))
    with pytest.raises(RecordingError, match=r"world to camera: .*--pose-convention world-to-camera"):
        reconstruct(recording, ReconstructSettings(poses=turned_round))
    millimetres = true.poses.copy()
    millimetres[:, :3, 3] *= 1000
    with pytest.raises(RecordingError, match="millimetres"):
        reconstruct(recording, ReconstructSettings(poses=replace(true, poses=millimetres)))


def test_what_they_show_together_is_a_room(room):
    recording, true = room
    chosen = plan(recording, ReconstructSettings(poses=true), default_sensor(CAMERA))
    assert (chosen.kind, chosen.reason) == ("room", "the walk shows 4.00 m")
