"""Missing frames and jumping clocks are told; uneven but honest recordings are not blamed."""

from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.checks.clocks import clock_jumps, missing_frames
from fusion.recording.checks.stamps import GAP, unit_of_stamps
from fusion.recording.recording import Frame, FrameStreams, Recording

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
        np.delete(np.arange(9) / 30, 4),  # too few steps to tell a rate
        np.append(np.arange(20) / 30, 21 / 30),  # the last one may have come late
        EVEN + np.where(np.arange(300) % 40 == 7, 1 / 30, 0.0),  # frames that came late, not missing ones
        np.cumsum(np.tile([1 / 30, 1 / 30, 2 / 30 + 0.01, 1 / 30 - 0.01], 20)),  # another exposure, now and then
    ],
)
def test_other_recordings_miss_nothing(stamps):
    assert not missing_frames(stamps, GAP)


@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_a_short_recording_tells_them_as_well(jitter):
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(200):
        stamps = (np.arange(24) + jitter * rng.standard_normal(24)) / 30
        told = missing_frames(np.delete(stamps, [5, 9, 14]), GAP)
        found += bool(told) and told[0].severity == "warning" and "3 of 24" in told[0].seen
    assert found > 180  # a clock that jitters by a twentieth costs the count itself in one of twenty


@pytest.mark.parametrize("frames", [60, 300, 3000])
def test_a_clock_that_jitters_by_3_ms_hides_no_lost_frames(frames):
    """Of a machine that stamps pictures when they arrive; lost frames, each alone and three in a row."""
    rng, found, silent = np.random.default_rng(3), 0, 0
    for _ in range(100):
        moments = 1.7e9 + np.arange(frames) / 30 * (1 + 3e-5) + 0.003 * rng.standard_normal(frames)
        lost = np.concatenate([rng.choice(np.arange(2, frames // 2, 3), 2, replace=False), frames // 2 + np.arange(3)])
        told = missing_frames(np.delete(moments, lost), GAP)
        found += bool(told) and f"5 of {frames}" in told[0].seen
        silent += not missing_frames(moments, GAP)
    assert found >= 95 and silent == 100


CHANCE = {
    "jitter": lambda rng, n: np.sort((np.arange(n) + rng.uniform(0, 0.3) * rng.standard_normal(n)) / 30),
    "even": lambda rng, n: np.cumsum(rng.uniform(0.02, 0.19, n)),
    "exponential": lambda rng, n: np.cumsum(0.01 + rng.exponential(0.05, n)),
    "log-normal": lambda rng, n: np.cumsum(0.05 * np.exp(0.5 * rng.standard_normal(n))),
}


@pytest.mark.parametrize("kind", CHANCE)
def test_steps_of_chance_hardly_ever_look_like_missing_frames(kind):
    rng = np.random.default_rng(11)
    alarms = sum(bool(missing_frames(CHANCE[kind](rng, int(rng.integers(9, 25))), GAP)) for _ in range(2000))
    assert alarms <= 8  # 0.1 % expected at most, and what chance adds
    alarms = sum(bool(missing_frames(CHANCE[kind](rng, int(rng.integers(40, 300))), GAP)) for _ in range(2000))
    assert alarms <= 8


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


@pytest.mark.parametrize(("times", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
@pytest.mark.parametrize("rate", [5.0, 29.97, 60.0])
def test_stamps_of_another_unit_are_told(times, unit, rate):
    (found,) = unit_of_stamps(np.arange(41) * times / rate)
    assert unit in found.do and found.severity == "warning"


@pytest.mark.parametrize("step", [1 / 30, 0.5, 7.0, 30.0, 500.0])  # cameras, tables, hands, series over hours
def test_stamps_in_seconds_are_not_doubted(step):
    assert not unit_of_stamps(np.arange(41) * step)
