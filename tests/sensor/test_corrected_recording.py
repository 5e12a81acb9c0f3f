"""Whole recordings corrected: telemetry of every kind, broken frames, a true camera."""

from pathlib import Path

import numpy as np
import pytest

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame, Recording
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.moments import UPTIME, moments_of
from fusion.sensor.sensor import Sensor

CAMERA = Camera(24, 16, 20.0, 20.0, 11.5, 7.5, principle="structured_light")
STAMPS = np.arange(4) * 10.0 + 100.0
DRIFT = Sensor(principle="structured_light", effects=(TemperatureDrift(coefficient=0.001),))


def recording(telemetry=None, stamps=STAMPS, broken=()):
    def load(index):
        if index in broken:
            raise RecordingError("the image cannot be read", f"frame {index}")
        return Frame(index, float(stamps[index]), np.full(CAMERA.shape, 1.0, np.float32))

    return Recording(Path("rec"), "made", CAMERA, np.asarray(stamps), load, telemetry=telemetry or {})


def test_each_frame_is_corrected_by_its_own_temperature():
    log = {"timestamp": STAMPS[[0, 3]], "temperature_c": np.array([25.0, 31.0])}
    better, told = corrected_recording(recording(log), DRIFT)
    found = [np.unique(frame.depth) for frame in better]
    # 1 mm per K above 25 degC, linear between two entries of the log
    assert np.allclose(np.ravel(found), [1.0, 0.998, 0.996, 0.994], atol=1e-6)
    assert told.left == ()


@pytest.mark.parametrize(
    "column", [None, [np.nan] * 4, [-1e9] * 4, [25.0, 26.0, 4e7, 25.0]], ids=["none", "blank", "code", "spike"]
)
def test_a_log_that_tells_no_temperature_changes_nothing_and_is_told(column):
    log = {} if column is None else {"timestamp": STAMPS, "temperature_c": np.array(column)}
    better, told = corrected_recording(recording(log), DRIFT)
    assert all((frame.depth == 1.0).all() for frame in better)
    assert told.left == ("temperature_drift: not corrected, the recording has no temperature",)
    implausible = column is not None and np.isfinite(column).all()
    assert any("temperature_c of the telemetry is not used" in text for text in better.warnings) == implausible


def test_stamps_that_are_dates_mean_a_warm_sensor():
    assert moments_of(recording())[1].time == 110.0
    assert moments_of(recording(stamps=STAMPS + 1.7e9))[1].time == UPTIME
    assert moments_of(recording(stamps=STAMPS - 500.0))[0].time == 0.0


def test_light_and_angle_come_from_the_log():
    log = {"timestamp": STAMPS, "ambient_lux": np.full(4, 800.0), "turntable_deg": np.arange(4) * 90.0}
    moment = moments_of(recording(log))[2]
    assert moment.ambient == 800.0 and moment.table_angle == pytest.approx(np.pi)
    nothing = moments_of(recording())[2]
    assert nothing.ambient == 0.0 and nothing.table_angle == 0.0 and np.isnan(nothing.temperature)


def test_the_true_camera_comes_with_the_corrected_depth():
    better, told = corrected_recording(recording(), Sensor(effects=(FocalLength(0.25),)))
    assert better.camera.fx == pytest.approx(16.0) and told.camera == ("focal_length",)
    assert told.notes == [("ok", "depth corrected: focal_length by the true camera")]


def test_broken_and_missing_frames_are_told_only_when_asked_for():
    better, _ = corrected_recording(recording(broken=(0, 2)), DRIFT)
    assert (better[1].depth == 1.0).all()
    with pytest.raises(RecordingError):
        better[2]
    assert len(corrected_recording(recording(stamps=STAMPS[:0]), DRIFT)[0]) == 0
