"""Missing frames and jumping clocks are told; uneven but honest recordings are not blamed."""

from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.checks.clocks import clock_jumps, missing_frames
from fusion.recording.checks.stamps import GAP
from fusion.recording.recording import Frame, Recording
from fusion.recording.streams import FrameStreams

EVEN = np.arange(300) / 30
CAMERA = Camera(8, 6, 10.0, 10.0, 3.5, 2.5)


def recording(device, machine=None, telemetry=None):
    shown = None if machine is None else FrameStreams(arrivals=machine)
    load = Frame(0, 0.0, np.ones(CAMERA.shape, np.float32))
    return Recording(Path("made"), "ros2", CAMERA, device, lambda i: load, streams=shown, telemetry=telemetry or {})


def jitter(seed, sigma):
    return np.abs(np.random.default_rng(seed).normal(0, sigma, len(EVEN)))


@pytest.mark.parametrize("rate", [15.0, 30.0, 90.0])
def test_dropped_frames_are_counted(rate):
    kept = np.delete(np.arange(400), [50, 120, 121, 300]) / rate
    (found,) = missing_frames(kept, GAP)
    assert "4 of 400 frames are missing" in found.seen and found.severity == "ok"


def test_many_of_them_are_a_warning():
    kept = np.delete(EVEN, np.arange(10, 290, 11))
    (found,) = missing_frames(kept, GAP)
    assert found.severity == "warning" and found.do


@pytest.mark.parametrize(
    "stamps",
    [
        EVEN,
        EVEN + 0.002 * np.sin(np.arange(300)),  # a computer's clock
        np.cumsum(np.random.default_rng(1).choice([5.0, 10.0, 7.0], 100)),  # a person who turns by hand
        np.cumsum(np.random.default_rng(2).uniform(0.02, 0.2, 300)),  # as fast as it came
        np.arange(12) / 30,
    ],
)
def test_other_recordings_miss_nothing(stamps):
    assert not missing_frames(stamps, GAP)


@pytest.mark.parametrize("jump", [-3.0, 0.4, 60.0])
def test_a_jump_of_the_device_s_clock_is_told_with_its_size(jump):
    device = EVEN + np.where(np.arange(300) >= 140, jump, 0.0)
    (found,) = clock_jumps(recording(device, 1.7e9 + EVEN + jitter(0, 0.01)))
    assert f"{jump:+.2f} s" in found.seen and "at frame 140" in found.seen


def test_clocks_of_a_native_recording_are_compared_too():
    logged = {"timestamp": EVEN, "device_s": EVEN + np.where(EVEN > 5, 1.5, 0.0), "host_s": 1.7e9 + EVEN}
    (found,) = clock_jumps(recording(EVEN, telemetry=logged))
    assert "+1.50 s" in found.seen


@pytest.mark.parametrize(
    "machine",
    [
        1.7e9 + EVEN * (1 + 50e-6) + jitter(1, 0.005),  # a usual drift
        1.7e9 + EVEN + np.where(np.abs(np.arange(300) - 100) < 5, 0.3, 0.0),  # held up, then caught up
        1.7e9 + EVEN / 20,  # played back at twenty times the rate
    ],
)
def test_a_slow_recorder_is_no_jump(machine):
    assert not clock_jumps(recording(EVEN, machine))
