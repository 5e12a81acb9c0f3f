"""A recording played back: its frames, its rate, its clocks; the same frames as the recording itself gives."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from fusion.devices.open import open_source
from fusion.devices.replay import Replay
from fusion.devices.source import SourceFrame
from fusion.errors import DeviceError, FusionError, RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(32, 24, 30.0, 30.0, 15.5, 11.5, depth_scale=5000.0, serial="A7")
COUNT, STEP = 6, 0.05


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(0)
    frames = [
        Frame(i, 100 + STEP * i, rng.uniform(0.5, 2, CAMERA.shape), rng.integers(0, 255, (24, 32, 3)).astype(np.uint8))
        for i in range(COUNT)
    ]
    log = {"timestamp": 100 + STEP * np.arange(COUNT), "turntable_deg": 3.0 * np.arange(COUNT)}
    write_recording(tmp_path / "rec", CAMERA, frames, telemetry=log)
    return tmp_path / "rec"


def test_the_frames_are_those_of_the_recording(folder):
    recording = open_recording(folder)
    with open_source(f"replay:{folder}@max") as source:
        played = list(source.frames())
    assert len(played) == COUNT
    for frame, own in zip(played, recording, strict=True):
        assert isinstance(frame, SourceFrame)
        assert (frame.index, frame.timestamp, frame.device_time) == (own.index, own.timestamp, own.timestamp)
        np.testing.assert_array_equal(frame.depth, own.depth)
        np.testing.assert_array_equal(frame.color, own.color)
        assert frame.log == {"turntable_deg": 3.0 * frame.index}
        assert frame.missed == 0
    assert np.all(np.diff([frame.host_time for frame in played]) >= 0)


def test_it_says_what_it_is(folder):
    told = open_source(f"replay:{folder}@4").describe()
    assert (told.name, told.serial, told.length, told.color, told.ir) == ("replay", "A7", COUNT, True, False)
    assert told.rate == pytest.approx(4 / STEP)
    assert told.camera == CAMERA
    assert repr(told) == "<Description: replay A7, 32 x 24, 80 a second, color>"


def test_it_takes_the_time_that_the_recording_took(folder):
    for speed, expected in ((1.0, STEP * (COUNT - 1)), (5.0, STEP * (COUNT - 1) / 5)):
        begin = time.monotonic()
        stamps = [time.monotonic() - begin for _ in Replay(open_recording(folder), speed).frames()]
        # no frame before its time; how late one may be is the machine's affair
        due = np.arange(COUNT) * STEP / speed
        assert np.all(np.array(stamps) >= due - 1e-3)
        assert stamps[-1] >= expected - 1e-3


def test_it_stops_while_it_waits(folder):
    recording = open_recording(folder)
    far = replace(recording, timestamps=recording.timestamps * np.array([1, *[1000.0] * (COUNT - 1)]))
    far = replace(far, load=lambda i: replace(recording[i], timestamp=float(far.timestamps[i])))
    source = Replay(far)
    timer = threading.Timer(0.1, source.stop)
    timer.start()
    assert len(list(source.frames())) == 1  # the second is a day away
    timer.join()
    with source:  # and starts again
        assert next(source.frames()).index == 0


def test_a_frame_that_cannot_be_read_is_missed_and_the_others_come(folder):
    (folder / "depth" / "000002.png").write_bytes(b"broken")
    with open_source(f"replay:{folder}@max") as source:
        assert [(frame.index, frame.missed) for frame in source.frames()] == [(0, 0), (1, 0), (3, 1), (4, 0), (5, 0)]
    for file in (folder / "depth").iterdir():
        file.write_bytes(b"broken")
    with open_source(f"replay:{folder}@max") as source, pytest.raises(RecordingError, match="damaged"):
        list(source.frames())


def test_names_that_are_none_are_told(folder, tmp_path):
    for name in ("kinect", "", "replay", "replay:", "webcam:3"):
        with pytest.raises(DeviceError, match="no such source"):
            open_source(name)
    with pytest.raises(DeviceError, match="to play a recording back: replay:"):
        open_source(str(folder))
    with pytest.raises(RecordingError, match="no recording"):
        open_source("replay:nothing-here@2")
    with pytest.raises(FusionError, match="speed of the replay is not possible"):
        open_source(f"replay:{folder}@0")
    strange = tmp_path / "rec@2"
    folder.rename(strange)
    assert open_source(f"replay:{strange}").describe().rate == pytest.approx(1 / STEP)
