"""A camera that was moved halfway is told; what turns, comes and goes, or is noisy before a firm one is not."""

import re
from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.checks.drift import check_camera_bumped, check_depth_drifts
from fusion.recording.looking.sample import draw
from fusion.recording.recording import Frame, Recording

CAMERA = Camera(80, 60, 70.0, 70.0, 39.5, 29.5, depth_scale=1000.0, principle="structured_light")
COUNT, AT = 36, 20


def sample(depth_of, noise=0.004, camera=CAMERA):
    """Frames of `depth_of(i)` with noise [m], rounded to millimetres."""

    def load(i):
        drawn = depth_of(i) + np.random.default_rng(i).normal(0, noise, camera.shape)
        return Frame(i, i / 10, np.round(drawn, 3).astype(np.float32))

    return draw(Recording(Path("made_up"), "native", camera, np.arange(COUNT) / 10, load), 12, 12)


def wall(turned=0.0):
    """A wall at 1.5 m, and a thing before it, seen by a camera that is turned by an angle [rad]."""
    x = (np.arange(80) - 39.5) / 70
    depth = np.tile(1.5 / (np.cos(turned) + x * np.sin(turned)), (60, 1))
    depth[40:, 20:60] = 0.8
    return depth


def turning(i):
    depth = wall()
    width = 8 + int(6 * np.sin(i))
    depth[15:45, 40 - width : 40 + width] = 0.9
    return depth


@pytest.mark.parametrize("turned", [0.035, -0.05])
def test_a_camera_that_was_turned_halfway_is_told_with_its_frames(turned):
    (finding,) = check_camera_bumped(sample(lambda i: wall(turned if i >= AT else 0.0)))
    assert finding.severity == "error" and "moved" in finding.seen
    before, after = map(int, re.findall(r"frames (\d+) and (\d+)", finding.seen)[0])
    assert before < AT <= after


@pytest.mark.parametrize("noise", [0.0, 0.004])
@pytest.mark.parametrize("depth_of", [turning, lambda i: wall(), lambda i: wall(0.02 * np.sin(i))])
def test_what_turns_or_sways_is_no_bump(depth_of, noise):
    assert check_camera_bumped(sample(depth_of, noise)) == []


def test_few_frames_say_nothing():
    few = sample(lambda i: wall(0.05 if i >= AT else 0.0))
    assert check_camera_bumped(type(few)(**{**vars(few), "depths": dict(list(few.depths.items())[:5])})) == []


FLIGHT = Camera(80, 60, 70.0, 70.0, 39.5, 29.5, depth_scale=1000.0, principle="itof")


@pytest.mark.parametrize(
    ("camera", "crept"),
    [
        (FLIGHT, lambda z, share: z - 0.008 * (1 - np.exp(-3 * share))),
        (CAMERA, lambda z, share: z + 0.02 * share * z**2),
    ],
)
def test_a_sensor_that_warms_up_is_told_and_is_no_camera_that_was_moved(camera, crept):
    drawn = sample(lambda i: crept(turning(i), i / COUNT), camera=camera)
    (finding,) = check_depth_drifts(drawn)
    assert finding.severity == "warning" and "warming up" in finding.do
    assert ("nearer" if camera is FLIGHT else "farther") in finding.seen
    assert check_camera_bumped(drawn) == []


@pytest.mark.parametrize("depth_of", [turning, lambda i: wall(0.035 if i >= AT else 0.0), lambda i: wall(0.002 * i)])
def test_what_turns_and_a_camera_that_moves_are_no_drift(depth_of):
    assert check_depth_drifts(sample(depth_of)) == []
