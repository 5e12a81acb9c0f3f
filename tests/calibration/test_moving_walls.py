"""Walls of a camera that moves, or that is warmer at each, or whose distances are typed in millimetres, are told."""

from pathlib import Path

import numpy as np
import pytest

from fusion.calibration.depth.calibration import calibrate_depth
from fusion.calibration.depth.walls.wall import check_distances
from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, Recording
from fusion.recording.writing.write import write_recording

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


def test_distances_typed_in_millimetres_are_refused_and_one_that_is_not_possible_is_not(tmp_path):
    def typed(name: str, factor: float, k: int = 0) -> Recording:
        made = wall(k, 1.2)
        stated = {"timestamp": made.timestamps, "distance_m": np.full(FRAMES, factor * 1.2)}
        write_recording(tmp_path / name, CAMERA, [made[i] for i in range(FRAMES)], telemetry=stated)
        return open_recording(tmp_path / name)

    with pytest.raises(FusionError, match=r"no stated distance can be used.*millimetres.*expected metres"):
        calibrate_depth([typed("a", 1000), typed("b", 1000, 1)])
    check_distances([typed("c", 1000), typed("d", 1)])


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


def test_somebody_who_walks_by_is_no_motion_of_the_wall():
    walls = [wall(k, z) for k, z in enumerate(PLACES)]
    for i in (4, 5, 6):
        walls[3][i].depth[20:72, 30:70] = 0.8
    assert not told(walls)


def test_where_all_moved_nothing_is_calibrated():
    with pytest.raises(
        FusionError, match=r"moved in every recording.*w0: the depth drifts by \+(59|60)\..*a still scene"
    ):
        calibrate_depth([wall(k, z, RECEDES) for k, z in enumerate(PLACES)])
