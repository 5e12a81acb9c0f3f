"""A recording of another scene, or poses of another recording, are told and not explained by laws."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import fusion
from fusion.discrepancy.belonging import refuse_ranges, refuse_strangers
from fusion.errors import RecordingError
from fusion.sensor.view import LIGHT_SPEED
from fusion.simulation.scenes.panel import wall

CAMERA = replace(fusion.find_camera("kinect-v1"), width=80, height=60, fx=73.0, fy=73.0, cx=39.5, cy=29.5)


class Look:
    """As much of a block of frames as is asked for."""

    def __init__(self, mean, depth):
        self.mean, self.view = mean, type("View", (), {"depth": depth, "stretch": np.ones_like(depth)})
        self.stage = type("Stage", (), {"recording": type("Recording", (), {"path": "rec"})})


def block(off):
    depth = np.linspace(1.0, 3.0, 400).reshape(20, 20)
    return Look(depth + off, depth)


@pytest.mark.parametrize("off", [-0.9, 1.3])
@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_depth_far_from_its_scene_is_refused(off, principle):
    with pytest.raises(RecordingError, match="do not belong together"):
        refuse_strangers([block(off)], fusion.Sensor(principle=principle))


def test_a_lost_phase_is_an_effect():
    period = LIGHT_SPEED / 2 / 100e6
    sensor = fusion.Sensor(principle="itof", frequencies=(100e6,))
    refuse_strangers([block(-period + 0.01)], sensor)
    with pytest.raises(RecordingError):
        refuse_strangers([block(-period + 0.3)], sensor)


def test_errors_of_sensors_are_none():
    refuse_strangers([block(0.1), Look(np.full((4, 4), np.nan), np.ones((4, 4)))], fusion.Sensor(principle="itof"))


def test_a_wall_elsewhere_than_its_poses_say_is_told_by_the_command(tmp_path):
    sensor = fusion.read_sensor("kinect-v1")
    fusion.write_simulation(tmp_path / "near", fusion.simulate(replace(wall(frames=4), camera=CAMERA), sensor, 1))
    poses = tmp_path / "near" / "groundtruth.txt"
    rows = np.loadtxt(poses)
    rows[:, 1] += 2.0  # farther from the wall
    np.savetxt(poses, rows)
    with pytest.raises(RecordingError, match=r"2\.00 m"):
        fusion.explain([fusion.open_recording(tmp_path / "near")], sensor)


def slanted(off, noise=0.003):
    """A slanted wall of which depths are wrong by some function of depth and of how much longer rays are."""
    rays = CAMERA.rays()
    depth = 1.5 / (1.0 - 0.3 * rays[..., 0])
    longer = np.sqrt(1.0 + (rays**2).sum(axis=-1))
    mean = off(depth, longer) + noise * np.random.default_rng(1).standard_normal(depth.shape)
    look = Look(mean, depth)
    look.view.camera = CAMERA
    return look


def test_distances_along_the_rays_are_told_as_such():
    with pytest.raises(RecordingError, match="distance along the ray"):
        refuse_ranges([slanted(lambda depth, longer: depth * longer)] * 3)


@pytest.mark.parametrize(
    "off",
    [
        lambda depth, longer: depth,
        lambda depth, longer: 1.02 * depth + 0.01,
        lambda depth, longer: depth + 0.02 * np.sin(2 * np.pi * depth * longer / 0.9),
        lambda depth, longer: depth + 0.05 * (longer - 1.0),
        lambda depth, longer: np.where(longer > 1.15, 0.8, depth),
    ],
)
def test_laws_and_things_before_a_wall_are_no_ranges(off):
    refuse_ranges([slanted(off)] * 3)


def test_a_recording_of_ranges_is_refused_by_the_command(tmp_path):
    sensor = fusion.read_sensor("kinect-v1")
    recorded = fusion.simulate(replace(wall(frames=4), camera=CAMERA), sensor, 1)
    longer = np.sqrt(1.0 + (CAMERA.rays() ** 2).sum(axis=-1)).astype(np.float32)
    fusion.write_simulation(tmp_path / "wall", recorded)
    for file in sorted((tmp_path / "wall" / "depth").glob("*.png")):
        depth = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(file), np.round(depth * longer).astype(np.uint16))
    with pytest.raises(RecordingError, match="distance along the ray"):
        fusion.explain([fusion.open_recording(tmp_path / "wall")], sensor)
