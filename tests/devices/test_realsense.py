"""RealSense by the maker's own library: a device that is made up, and a recording of its own played back."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyrealsense2", reason="pyrealsense2, of the extra realsense, is not installed")
import pyrealsense2 as rs

from fusion.devices import realsense
from fusion.devices.open import open_source
from fusion.devices.realsense import RealSense
from fusion.devices.record import RecordSettings, record_source
from fusion.errors import DeviceError
from fusion.recording.open import open_recording

BAGS = Path(__file__).resolve().parents[1] / "recording" / "bags"
DEPTH, COLOR = (64, 48), (56, 40)
UNIT = 0.0001


def profile(kind, uid, form, bytes_each, size, coefficients):
    stream, lens = rs.video_stream(), rs.intrinsics()
    stream.type, stream.index, stream.uid, stream.fmt, stream.fps, stream.bpp = kind, 0, uid, form, 30, bytes_each
    stream.width, stream.height = lens.width, lens.height = size
    lens.fx, lens.fy, lens.ppx, lens.ppy = 55.0, 56.0, size[0] / 2 - 0.5, size[1] / 2 - 0.5
    lens.model, lens.coeffs = rs.distortion.inverse_brown_conrady, coefficients
    stream.intrinsics = lens
    return stream


class Made:
    """A D405 that the SDK takes for a device, and frames that are pushed through it."""

    def __init__(self):
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "Intel RealSense D405")
        self.device.register_info(rs.camera_info.serial_number, "0123")
        self.stereo, self.rgb = self.device.add_sensor("Stereo Module"), self.device.add_sensor("RGB Camera")
        self.depth = self.stereo.add_video_stream(profile(rs.stream.depth, 1, rs.format.z16, 2, DEPTH, [0.0] * 5))
        lens = [0.08, -0.12, 0.002, -0.001, 0.03]
        self.color = self.rgb.add_video_stream(profile(rs.stream.color, 2, rs.format.rgb8, 3, COLOR, lens))
        self.stereo.add_read_only_option(rs.option.depth_units, UNIT)
        place = rs.extrinsics()
        place.rotation, place.translation = [0, 1, 0, -1, 0, 0, 0, 0, 1], [0.015, 0.001, 0.0]
        self.depth.register_extrinsics_to(self.color, place)

    def push(self, number, kinds=("depth", "color")):
        for kind in kinds:
            sensor, stream = (self.stereo, self.depth) if kind == "depth" else (self.rgb, self.color)
            pixels = np.full(DEPTH[::-1], 5000 + number, np.uint16)
            if kind == "color":
                pixels = np.full((*COLOR[::-1], 3), number, np.uint8)
            else:
                pixels[0, 0] = 0
            frame = rs.software_video_frame()
            frame.pixels, frame.bpp = pixels, 2 if kind == "depth" else 3
            frame.stride = pixels.shape[1] * frame.bpp
            frame.timestamp = 1000 + 1000 / 30 * number + (4.0 if kind == "color" else 0.0)
            frame.domain, frame.frame_number = rs.timestamp_domain.hardware_clock, number
            frame.profile = stream.as_video_stream_profile()
            sensor.on_video_frame(frame)

    def push_all(self, numbers, pause=0.02):
        def run():
            time.sleep(0.1)
            for number in numbers:
                self.push(number)
                time.sleep(pause)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        return thread


def test_cameras_unit_and_frames_are_those_of_the_device():
    made = Made()
    source = RealSense(made.device)
    told = source.describe()
    assert (told.serial, told.color, told.ir, told.rate) == ("0123", True, False, 30.0)
    assert told.camera.depth_scale == pytest.approx(1 / UNIT)
    assert (told.camera.principle, told.camera.sensor) == ("active_stereo", "RealSense D405")
    assert told.camera.color.distortion[:5] == pytest.approx((0.08, -0.12, 0.002, -0.001, 0.03))
    # the rotation's columns are one after the other: x of depth is y of colour
    np.testing.assert_allclose(told.camera.T_color_depth @ [1, 0, 0, 1], [0.015, 1.001, 0, 1], atol=1e-6)
    with source:
        made.push_all([0, 1, 2, 5, 6])
        frames = [frame for _, frame in zip(range(5), source.frames(), strict=False)]
    for frame, number in zip(frames, (0, 1, 2, 5, 6), strict=True):
        assert np.isnan(frame.depth[0, 0])
        np.testing.assert_allclose(frame.depth[1:], (5000 + number) * UNIT, rtol=1e-6)
        assert (frame.color_apart == number).all()
        assert frame.device_time == pytest.approx(1 + number / 30)
        assert abs(frame.host_time - time.time()) < 60
    assert [frame.missed for frame in frames] == [0, 0, 0, 2, 0]


def test_it_is_recorded_count_for_count(tmp_path):
    made = Made()
    with RealSense(made.device) as source:
        thread = made.push_all(range(10))
        done = record_source(source, tmp_path / "rec", RecordSettings(frames=10))
        thread.join()
    assert (done.frames, done.missed) == (10, 0)
    recording = open_recording(tmp_path / "rec")
    for number in range(10):
        assert (recording.depth_counts(number)[1:] == 5000 + number).all()
        assert (recording.color_apart(number) == number).all()


def test_silence_and_stopping(monkeypatch):
    monkeypatch.setattr(realsense, "SILENCE", 0.5)
    with RealSense(Made().device) as source, pytest.raises(DeviceError, match="sends no frames"):
        next(source.frames())
    made = Made()
    with RealSense(made.device) as source:
        made.push_all(range(3))
        threading.Timer(0.4, source.stop).start()
        assert 1 <= len(list(source.frames())) <= 3


def test_a_device_without_depth_and_none_at_all():
    bare = rs.software_device()
    bare.add_sensor("nothing")
    with pytest.raises(DeviceError, match="no depth stream"):
        RealSense(bare)
    with pytest.raises(DeviceError, match=r"no such RealSense.*found"):
        open_source("realsense:99")


def test_what_the_sdk_recorded_is_played_back():
    """The sample that tools/formats/samples/realsense.py made, against our own reader of it."""
    path = BAGS / "realsense_2_59.db3"
    device = rs.context().load_device(str(path))
    device.set_real_time(False)
    with RealSense(device) as source:
        frames = list(source.frames())
    recording = open_recording(path)
    assert len(frames) == len(recording)
    assert source.describe().camera.fx == pytest.approx(recording.camera.fx)
    for frame, own in zip(frames, recording, strict=True):
        np.testing.assert_allclose(frame.depth, own.depth, rtol=1e-6)
