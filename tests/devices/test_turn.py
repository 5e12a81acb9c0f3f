"""One turn of a table is seen: by its log, else by the first view that comes back."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import fusion
from fusion.devices.source import SourceFrame
from fusion.devices.turn import TurnWatch

CAMERA = fusion.Camera(160, 120, 144.0, 144.0, 80.0, 60.0, depth_scale=5000.0, principle="structured_light")
TURNS = 1.3


@lru_cache(maxsize=4)
def simulated(frames, uneven_sd_deg=0.0):
    """The demo's owl, turning, as a Kinect sees it."""
    scene = fusion.built_in("turntable", {"frames": frames, "turns": TURNS, "uneven_sd_deg": uneven_sd_deg})
    made = fusion.simulate(replace(scene, camera=CAMERA), fusion.read_sensor("kinect-v1"), seed=3)
    return list(made.frames())


def stopped_at(frames, color=True):
    """Number of the frame at which a turn was seen, or None."""
    watch = TurnWatch()
    given = (SourceFrame(f.index, f.timestamp, f.depth, f.color if color else None) for f in frames)
    return next((frame.index for frame in given if watch.seen(frame)), None)


# steps of 7.8, 11.7 and 7.8 degrees, as tables with steps are used; the last with steps of uneven size
SLOW = pytest.mark.slow
TABLES = [(60, 0.0), pytest.param(40, 0.0, marks=SLOW), pytest.param(60, 1.0, marks=SLOW)]


@pytest.mark.parametrize(("frames", "uneven_sd_deg"), TABLES)
def test_the_first_view_is_known_again(frames, uneven_sd_deg):
    seen = simulated(frames, uneven_sd_deg)
    for color in (True, False):
        stop = stopped_at(seen, color)
        assert stop is not None
        # not before the turn is whole, and within a sixth of a turn after it
        assert 360 - 360 * TURNS / frames <= stop * 360 * TURNS / frames <= 420


def test_a_table_that_begins_late_and_one_that_never_turns():
    seen = simulated(60)
    rng = np.random.default_rng(5)
    still = [replace(seen[0], depth=seen[0].depth + rng.normal(0, 1e-3, CAMERA.shape)) for _ in range(40)]
    assert stopped_at([replace(frame, index=i) for i, frame in enumerate(still)]) is None
    later = [replace(frame, index=i) for i, frame in enumerate([*still[:15], *seen])]
    stop = stopped_at(later)
    assert stop is not None
    assert 360 - 8 <= (stop - 15) * 360 * TURNS / 60 <= 420


def test_less_than_a_turn_is_none():
    assert stopped_at(simulated(60)[:40]) is None


def test_a_log_of_the_angle_is_believed():
    watch, empty = TurnWatch(), np.full((4, 4), 1.0, np.float32)
    angles = -10.0 + 7.0 * np.arange(100)
    told = [watch.seen(SourceFrame(i, i, empty, log={"turntable_deg": -a})) for i, a in enumerate(angles)]
    assert told.index(True) == 52  # 364 degrees
