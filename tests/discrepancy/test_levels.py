"""Depths that a file rounds once more are told as the steps of the sensor that they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.discrepancy.levels import at_levels
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.sensor import Sensor

CAMERA = Camera(64, 48, 575.0, 575.0, 32.0, 24.0, depth_scale=1000.0, principle="structured_light")
SENSOR = Sensor("made up", "structured_light", (AxialNoise(c0=0.002), DepthQuantization(step_px=0.125)))
FOCAL_BASELINE = CAMERA.fx * SENSOR.baseline


def walls(folder, offset=0.0, depths=(0.8, 1.1, 1.9)):
    """Noisy walls at steps of 1/8 px and at these, stored in millimetres after an offset."""
    rng, out, levels = np.random.default_rng(0), [], []
    for place, depth in enumerate(depths):
        noisy = rng.normal(depth, 0.003, CAMERA.shape)
        levels.append(FOCAL_BASELINE / (np.round(FOCAL_BASELINE / noisy / 0.125) * 0.125))
        frame = Frame(0, 0.0, (levels[-1] + offset).astype(np.float32))
        write_recording(folder / str(place), CAMERA, iter([frame]), None)
        out.append(open_recording(folder / str(place)))
    return out, levels


def test_millimetres_are_told_as_the_steps_they_stand_for(tmp_path):
    recordings, levels = walls(tmp_path)
    assert np.nanmax(np.abs(recordings[0][0].depth - levels[0])) > 2e-4
    for seen, level in zip(at_levels(recordings, SENSOR), levels, strict=True):
        assert seen[0].depth == pytest.approx(level, abs=1e-6) and seen[0].depth.dtype == np.float32


def test_steps_closer_than_counts_stay(tmp_path):
    recordings, _ = walls(tmp_path, depths=(0.45, 1.1))
    near, far = at_levels(recordings, SENSOR)
    assert np.array_equal(near[0].depth, recordings[0][0].depth)
    assert not np.array_equal(far[0].depth, recordings[1][0].depth)


@pytest.mark.parametrize(
    "sensor",
    [
        replace(SENSOR, effects=SENSOR.effects[:1]),
        replace(SENSOR, effects=(DepthQuantization(step=0.001),)),
        replace(SENSOR, effects=(DepthQuantization(step_px=0.11),)),
    ],
    ids=["no steps", "counts alone", "other steps"],
)
def test_what_is_no_step_of_the_model_stays(tmp_path, sensor):
    recordings, _ = walls(tmp_path)
    assert at_levels(recordings, sensor) is recordings


def test_what_was_moved_after_its_rounding_stays(tmp_path):
    recordings, _ = walls(tmp_path, offset=0.0011)
    assert at_levels(recordings, SENSOR) is recordings
