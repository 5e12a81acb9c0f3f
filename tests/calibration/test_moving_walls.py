"""Walls of a camera that moves, or that is warmer at each, are told."""

from pathlib import Path

import numpy as np
import pytest

from fusion.calibration.depth.calibration import calibrate_depth
from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame, Recording

CAMERA = Camera(96, 72, 90.0, 90.0, 47.5, 35.5, depth_scale=10000, principle="itof", sensor="made up", serial="7")
NOISE, FRAMES, OFFSET = 0.004, 12, 0.008  # [m]
PLACES = (0.7, 0.9, 1.1, 1.4, 1.7, 2.0, 2.4, 2.8)
STILL = np.zeros(FRAMES)
RECEDES, SWAYS = 0.002 * np.arange(FRAMES), 0.01 * np.sin(1.3 * np.arange(FRAMES))


def wall(k: int, place: float, motion: np.ndarray = STILL) -> Recording:
    """A wall at a stated place [m], measured 8 mm too far, moved [m] in each frame."""
    rng = np.random.default_rng(k)
    frames = []
    for i, by in enumerate(motion):
        depth = (place + by + OFFSET + NOISE * rng.standard_normal(CAMERA.shape)).astype(np.float32)
        frames.append(Frame(i, k * 100 + i / 30, depth))
    stamps = np.array([frame.timestamp for frame in frames])
    stated = {"timestamp": stamps, "distance_m": np.full(len(stamps), place)}
    return Recording(Path(f"w{k}"), "native", CAMERA, stamps, frames.__getitem__, telemetry=stated)


def ordered(places: tuple[float, ...]) -> list[str]:
    """What is said of walls at these places [m], recorded one after the other."""
    found = calibrate_depth([wall(k, place) for k, place in enumerate(places)])
    assert found.chosen > 0
    return [text for _, text in found.notes if "warmed up" in text]


def test_distances_in_the_order_of_time_are_told_to_hide_a_drift():
    (up,), (down,) = ordered(PLACES), ordered(PLACES[::-1])
    assert "each wall is farther than" in up and "the wall at 0.70 m again at the end" in up
    assert "each wall is nearer than" in down and "the wall at 2.80 m again at the end" in down


@pytest.mark.parametrize("places", [(*PLACES, PLACES[0]), (*PLACES[::2], *PLACES[1::2])])
def test_a_distance_again_at_the_end_or_another_order_tells_a_drift(places):
    assert not ordered(places)


def told(recordings: list[Recording]) -> list[str]:
    """Recordings that are left out as they moved."""
    notes = [text for _, text in calibrate_depth(recordings).notes]
    return [text.split(":")[0] for text in notes if "moved, and it is left out" in text]


@pytest.mark.parametrize("motion", [RECEDES, SWAYS])
def test_a_wall_that_moved_is_named_and_left_out(motion):
    walls = [wall(k, z, motion if k == 3 else STILL) for k, z in enumerate(PLACES)]
    assert told(walls) == ["w3"]
    assert len(calibrate_depth(walls).walls) == len(PLACES) - 1


def test_still_walls_are_all_taken():
    assert not told([wall(k, z) for k, z in enumerate(PLACES)])


def test_where_all_moved_nothing_is_calibrated():
    with pytest.raises(
        FusionError, match=r"moved in every recording.*w0: the depth drifts by \+(59|60)\..*a still scene"
    ):
        calibrate_depth([wall(k, z, RECEDES) for k, z in enumerate(PLACES)])
