"""Frames of a model made with right poses agree with it; with wrong ones they say where it is wrong."""

from types import SimpleNamespace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.scan.judging.agreement import agreement
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.turntable import Turntable
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 190.0, 191.0, 80.3, 59.1, principle="itof")
COUNT, STEP_DEG = 18, 20.0
MOTION = SimpleNamespace(bottom=0.0, plate=None, top=0.3, radius=0.12)
START = looking_at(np.array([0.5, 0.05, 0.28]), np.array([0.0, 0.0, 0.10]))


def poses(step_deg=STEP_DEG):
    return Turntable(degrees_per_frame=step_deg, frames=COUNT).T_object_camera(START, step_deg * np.arange(COUNT))


@pytest.fixture(scope="module")
def frames():
    caster = RayCaster(demo_object())
    depths = [caster.view(CAMERA, T).depth for T in poses()]
    return [prepare(Frame(i, 0.1 * i, depth), CAMERA, Sensor()) for i, depth in enumerate(depths)]


def agreed(frames, T, without=()):
    volume = Volume(VolumeSettings(0.003, 0.012, bounds=((-0.15, -0.15, -0.05), (0.15, 0.15, 0.35))))
    for i, frame in enumerate(frames):
        if i not in without:
            fuse(volume, frame, T[i])
    return agreement(volume, frames, T, MOTION)


def test_frames_agree_with_a_model_of_right_poses(frames):
    found = agreed(frames, poses())
    assert found.against < 0.01 and found.bent < 0.001
    assert len(found.frames) == 16 and found.frames[[0, -1]].tolist() == [0, COUNT - 1]


def test_frames_contradict_a_model_of_wrong_turns(frames):
    found = agreed(frames, poses(0.8 * STEP_DEG))
    # a small round owl, turned by 16 instead of 20 degrees a frame: what its ears and beak tell
    assert found.against > 0.02 and found.before.mean() > 0 and found.through.mean() > 0


def test_a_turn_that_never_was_is_contradicted(frames):
    assert agreed(frames, poses(0.0)).against > 0.1


def test_what_the_model_lacks_is_missing(frames):
    found = agreed(frames, poses(), without=range(8, 16))
    assert found.missing[10] > 0.2 and found.missing[0] < 0.02


def test_frames_without_a_place_are_not_asked(frames):
    T = poses()
    T[3] = np.nan
    assert 3 not in agreed(frames, T, without=[3]).frames
    found = agreement(Volume(VolumeSettings(0.003, 0.012)), frames, np.full_like(T, np.nan), MOTION)
    assert len(found.frames) == 0 and np.isnan(found.against)
