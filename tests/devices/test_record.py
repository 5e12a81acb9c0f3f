"""What is recorded is what came, whole at every moment, and what was lost is told."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.devices import record as record_module
from fusion.devices.growing import GrowingFolder, append
from fusion.devices.record import RecordSettings, record_source
from fusion.errors import DeviceError, FusionError
from fusion.recording.images.read import read_counts
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

sys.path.insert(0, str(Path(__file__).resolve().parent))
from made_up_kinect import CAMERA, MadeUp, frame

HERE = str(Path(__file__).resolve().parent)


def assert_whole(folder: Path) -> int:
    """Every frame that is listed can be read, and is the one that came; returns how many there are."""
    recording = open_recording(folder)
    assert not recording.warnings
    for index, read in enumerate(recording):
        came = frame(index)
        np.testing.assert_array_equal(np.rint(read.depth * 5000), np.rint(came.depth * 5000))
        np.testing.assert_array_equal(read.color, came.color)
        np.testing.assert_array_equal(read_counts(folder / "raw" / f"{index:06d}.png"), came.raw)
    return len(recording)


def test_frames_raw_values_clocks_and_tables_are_kept(tmp_path):
    done = record_source(MadeUp(6, missing={2: 3, 5: 1}), tmp_path / "rec")
    assert (done.frames, done.missed, done.ended) == (6, 4, "source")
    assert assert_whole(tmp_path / "rec") == 6
    recording = open_recording(tmp_path / "rec")
    log = recording.telemetry
    np.testing.assert_allclose(recording.timestamps, [frame(i).timestamp for i in range(6)], atol=1e-6)
    np.testing.assert_allclose(log["device_s"], [frame(i).device_time for i in range(6)], atol=1e-6)
    np.testing.assert_allclose(log["host_s"], [frame(i).host_time for i in range(6)], atol=1e-6)
    np.testing.assert_array_equal(log["missed"], [0, 0, 3, 0, 0, 1])
    np.testing.assert_array_equal(log["temperature_c"], 30 + np.arange(6))
    told = json.loads((tmp_path / "rec" / "device.json").read_text())
    assert told["tables"] == {"zero": [120.0, 7.5]}
    assert told["serial"] == recording.camera.serial == "A7"


def test_clocks_outlive_a_second_writing(tmp_path):
    """Seconds since 1970 need more digits than other quantities have."""
    record_source(MadeUp(3), tmp_path / "rec")
    once = open_recording(tmp_path / "rec")
    write_recording(tmp_path / "again", once.camera, once, telemetry=once.telemetry)
    np.testing.assert_array_equal(open_recording(tmp_path / "again").telemetry["host_s"], once.telemetry["host_s"])


def test_it_ends_when_the_settings_say_so(tmp_path):
    source = MadeUp(100)
    done = record_source(source, tmp_path / "rec", RecordSettings(frames=4, every=3))
    assert (done.frames, done.ended) == (4, "frames")
    assert [read.timestamp for read in open_recording(tmp_path / "rec")] == pytest.approx(
        [frame(i).timestamp for i in (0, 3, 6, 9)], abs=1e-6
    )
    assert source.given < 100


def test_a_slow_disk_holds_up_the_taking_and_loses_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(record_module, "QUEUE_BYTES", 1)  # the least room: 8 frames
    write, source, gaps = GrowingFolder.add, MadeUp(40), []

    def slow(self, one):
        time.sleep(0.01)
        gaps.append(source.given - self.count)
        write(self, one)

    monkeypatch.setattr(GrowingFolder, "add", slow)
    done = record_source(source, tmp_path / "rec")
    assert (done.frames, done.missed, done.room) == (40, 0, 8)
    assert assert_whole(tmp_path / "rec") == 40
    # written, waiting, in the hands of either thread: no more frames than that are ever held
    assert done.fullest <= 8
    assert 8 <= max(gaps) <= 8 + 2


def test_a_device_that_goes_away_leaves_what_it_gave(tmp_path):
    gone = DeviceError("the camera is gone", "kinect-v1", do="plug it in again")
    with pytest.raises(DeviceError, match=r"the camera is gone.*plug it in again; the 5 frames before are kept in"):
        record_source(MadeUp(5, error=gone), tmp_path / "rec")
    assert assert_whole(tmp_path / "rec") == 5
    with pytest.raises(DeviceError, match=r"^the camera is gone; in kinect-v1; plug it in again$"):
        record_source(MadeUp(0, error=gone), tmp_path / "none")
    with pytest.raises(DeviceError, match="no frame came"):
        record_source(MadeUp(0), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_full_disk_leaves_what_found_room(tmp_path, monkeypatch):
    write = Path.write_bytes

    def full(self, data):
        if self.name == "000003.png" and self.parent.name == "depth":
            write(self, data[:10])
            raise OSError(28, "No space left on device", str(self))
        return write(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(FusionError, match=r"disk is full.*the 3 frames before are kept"):
        record_source(MadeUp(100), tmp_path / "rec")
    assert assert_whole(tmp_path / "rec") == 3
    assert not (tmp_path / "rec" / "depth" / "000003.png").exists()


def test_a_line_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "depth.txt"
    append(path, "one\n")

    def brim(handle, data):
        if len(data) < 4:
            raise OSError(28, "No space left on device")
        return os.write(handle, data[:2])

    with pytest.raises(OSError, match="No space"):
        append(path, "two\n", brim)
    assert path.read_text() == "one\n"


RECORDER = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in what a shell runs in the background
sys.path.insert(0, sys.argv[1])
from made_up_kinect import MadeUp
from fusion.devices import open as opening
opening.open_source = lambda name, camera=None, infrared=False: MadeUp(100_000, 0.001)
from fusion.commands.console import run
sys.argv = ["fusion", "record", "replay:nothing", "-o", sys.argv[2], "--overwrite", *sys.argv[3:]]
raise SystemExit(run())
"""


def started(folder: Path) -> subprocess.Popen:
    """A process that records until it is ended, seen to have recorded some frames."""
    words = [sys.executable, "-c", RECORDER, HERE, str(folder)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    limit = time.monotonic() + 60
    while not (folder / "depth" / "000010.png").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < limit
        time.sleep(0.01)
    return process


def test_killed_at_any_moment_it_is_whole(tmp_path):
    for moment in (0.0, 0.013):  # a frame takes some 5 ms: between any two of its steps
        folder = tmp_path / f"rec{moment}"
        process = started(folder)
        time.sleep(moment)
        process.kill()
        process.communicate()
        assert assert_whole(folder) >= 10


def test_stopped_by_hand_it_is_a_recording_and_no_failure(tmp_path):
    for number in (signal.SIGINT, signal.SIGTERM):
        process = started(tmp_path / f"rec{number}")
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
        assert process.returncode == 0, err
        frames = assert_whole(tmp_path / f"rec{number}")
        assert f"{frames} frames in" in out
        assert "none lost; stopped by hand" in out
        assert not list(tmp_path.glob(".partial-*"))


def test_a_recording_is_replaced_only_by_the_first_frame_of_a_new_one(tmp_path, capsys):
    given, out = tmp_path / "given", tmp_path / "rec"
    write_recording(given, CAMERA, [frame(i) for i in range(5)])
    words = ["record", f"replay:{given}@max", "-o", str(out), "--quiet"]
    assert main(words) == 0
    assert "5 frames in 0.1 s, 30.0 a second, none lost; the source ended" in capsys.readouterr().out
    (out / "mine.txt").write_text("mine")
    assert main(words) == 1
    assert "--overwrite" in capsys.readouterr().err
    assert main(["record", "replay:nothing", "-o", str(out), "--overwrite"]) == 1
    assert len(open_recording(out)) == 5
    assert main([*words, "--overwrite", "--frames", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out.rpartition("{")[2].join("{ "))["frames"] == 2
    assert len(open_recording(out)) == 2
    assert len(list((out / "depth").iterdir())) == 2  # nothing of the older one is left
    assert (out / "mine.txt").read_text() == "mine"
