"""The Kinect as a source, on faked USB: frames in metres, streams that stall or go away, the end of it."""

import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("usb.core", reason="pyusb, of the extra kinect, is not installed")
sys.path.insert(0, str(Path(__file__).resolve().parent))
from fake_usb import SERIAL, FakeDevice, FakePort, USBError

from fusion.devices.kinect_v1 import find, kinect, port
from fusion.devices.open import open_source
from fusion.devices.record import RecordSettings, record_source
from fusion.errors import DeviceError
from fusion.recording.open import open_recording


@pytest.fixture
def device(monkeypatch):
    """A camera that is plugged in, and its port; `device.plugged` may be changed."""
    camera = FakeDevice()
    camera.plugged = [camera]
    monkeypatch.setattr(find, "all_devices", lambda: camera.plugged)
    monkeypatch.setattr(port, "Port", FakePort)
    monkeypatch.setattr(FakePort, "camera", camera)
    monkeypatch.setattr(FakePort, "opened", 0)
    monkeypatch.setattr(FakePort, "script", ["run"])
    core = type("core", (), {"USBError": USBError, "NoBackendError": RuntimeError})
    monkeypatch.setattr(kinect, "usb_module", lambda: core)
    monkeypatch.setattr(kinect, "SILENCE", 0.3)
    monkeypatch.setattr(kinect, "RETURN", 1.0)
    return camera


def test_frames_hold_raw_values_metres_and_colours(device):
    with open_source("kinect-v1") as source:
        told = source.describe()
        frames = [frame for _, frame in zip(range(5), source.frames(), strict=False)]
    assert (told.serial, told.rate, told.color, told.ir) == (SERIAL, 30.0, True, False)
    assert told.camera.color is not None
    assert set(told.tables) == {"zero_plane_cm", "registration", "padding"}
    for i, frame in enumerate(frames):
        assert (frame.index, frame.missed) == (i, 0)
        assert (frame.raw == 600 + i).all()
        assert np.allclose(frame.depth, source._metres[600 + i])
        assert (frame.color_apart == i).all()
        assert frame.device_time == pytest.approx(i / 30)
    assert device.registers[6] == device.registers[5] == 0  # stopped


def test_infrared_instead_of_colours(device):
    with open_source("kinect-v1", infrared=True) as source:
        assert source.describe().ir
        assert device.registers[5] == 3


def test_a_camera_that_is_plugged_in_again_goes_on(device):
    FakePort.script = ["gone after 3", "gone after 2", "run"]
    with open_source("kinect-v1") as source:
        frames = [frame for _, frame in zip(range(8), source.frames(), strict=False)]
    assert [int(frame.raw[0, 0]) for frame in frames] == [600, 601, 602, 600, 601, 600, 601, 602]
    assert np.all(np.diff([frame.device_time for frame in frames]) > 0)
    assert all(frames[i].missed >= 1 for i in (3, 5))
    assert sum(frame.missed for frame in frames) == sum(frames[i].missed for i in (3, 5))


def test_a_camera_that_stays_away_ends_it_in_a_sentence(device):
    FakePort.script = ["gone after 2"]

    def unplug():
        device.plugged = []

    threading.Timer(0.05, unplug).start()
    frames = []
    with open_source("kinect-v1") as source, pytest.raises(DeviceError, match=r"unplugged.*no Kinect v1.*waited for"):
        frames.extend(source.frames())
    assert len(frames) >= 2


def test_silence_starts_the_streams_anew_and_is_given_up_in_the_end(device):
    FakePort.script = ["silent", "run"]
    with open_source("kinect-v1") as source:
        assert next(source.frames()).index == 0
        assert FakePort.opened == 2
    FakePort.script, FakePort.opened = ["silent"], 0
    with open_source("kinect-v1") as source, pytest.raises(DeviceError, match=r"the camera sends no frames.*power"):
        next(source.frames())
    assert FakePort.opened == 1 + kinect.STARTS


def test_errors_of_usb_are_sentences(device):
    for number, words in (
        (19, "was unplugged"),
        (13, "may not be opened"),
        (32, "refused a command"),
        (5, "USB failed"),
    ):
        device.error = USBError("words of libusb", number)
        with pytest.raises(DeviceError, match=words):
            open_source("kinect-v1")


def test_stopping_from_another_thread_ends_the_frames(device):
    with open_source("kinect-v1") as source:
        threading.Timer(0.3, source.stop).start()
        begin = time.monotonic()
        assert len(list(source.frames())) > 3
        assert time.monotonic() - begin < 5
        source.start()  # and again
        assert next(source.frames()).raw is not None


def test_a_taker_that_is_too_slow_is_told_what_it_missed(device):
    with open_source("kinect-v1") as source:
        frames = source.frames()
        seen = [next(frames) for _ in range(5)]
        time.sleep(1.5)  # 90 frames, of which 30 find room
        seen += [next(frames) for _ in range(40)]
    numbers = np.array([int(frame.raw[0, 0]) - 600 for frame in seen])
    np.testing.assert_array_equal(np.diff(numbers) - 1, [frame.missed for frame in seen[1:]])
    assert sum(frame.missed for frame in seen) > 20


def test_it_is_recorded_with_raw_values_and_tables(device, tmp_path):
    with open_source("kinect-v1") as source:
        done = record_source(source, tmp_path / "rec", RecordSettings(frames=4))
    assert done.missed == 0
    recording = open_recording(tmp_path / "rec")
    assert recording.color_is_apart
    assert recording.camera.serial == SERIAL
    assert not recording.warnings
    for i, frame in enumerate(recording):
        assert np.allclose(frame.depth, source._metres[600 + i], atol=1e-4)
        assert (recording.color_apart(i) == i).all()
