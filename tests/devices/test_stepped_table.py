"""A table that is turned step by step: by an emulated controller that speaks GRBL, or by a command."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.devices import open as opening
from fusion.devices.record import record_source
from fusion.devices.source import SourceFrame
from fusion.devices.table import grbl as driver
from fusion.devices.table.command import Command
from fusion.devices.table.grbl import Grbl
from fusion.devices.table.stepped import Stepped, open_table
from fusion.errors import DeviceError
from fusion.recording.open import open_recording

sys.path.insert(0, str(Path(__file__).resolve().parent))
from grbl_emulator import Emulated
from made_up_kinect import MadeUp, frame

HERE = str(Path(__file__).resolve().parent)


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    """Faults are waited for shortly."""
    pytest.importorskip("serial", reason="pyserial, of the extra table, is not installed")
    for name, value in (("BOOT", 0.3), ("ANSWER", 0.5), ("STILL", 0.5)):
        monkeypatch.setattr(driver, name, value)


class Watching(MadeUp):
    """A camera that sees where the table is: its depth [m] is 1 and a thousandth of the angle; none while it turns."""

    def __init__(self, table: Emulated) -> None:
        super().__init__(100_000, 0.005)
        self.table = table

    def frames(self) -> Iterator[SourceFrame]:
        for one in super().frames():
            standing = self.table.standing
            depth = np.full_like(one.depth, np.nan if standing is None else 1 + standing / 1000)
            yield replace(one, depth=depth, host_time=time.time())


def test_each_place_is_grabbed_after_the_table_came_to_rest(tmp_path):
    with Emulated() as table, Stepped(Watching(table), Grbl(table.name), 30.0, 0.02) as source:
        done = record_source(source, tmp_path / "rec")
        lines = table.lines
    assert (done.frames, done.missed, done.ended) == (13, 0, "source")
    recording = open_recording(tmp_path / "rec")
    told = recording.telemetry_at_frames("turntable_deg")
    np.testing.assert_allclose(told, 30.0 * np.arange(13), atol=0.01)
    for angle, seen in zip(told, recording, strict=True):
        np.testing.assert_allclose(seen.depth, 1 + angle / 1000, atol=2e-4)  # no frame of a moving table, or of before
    # absolute, so that what is rounded does not add up
    assert lines[1:4] == ["$J=G53G21X123.500F600", "$J=G53G21X153.500F600", "$J=G53G21X183.500F600"]


class Turning(MadeUp):
    """A camera before a simulated object that stands as the table does."""

    def __init__(self, table: Emulated, recording) -> None:
        super().__init__(100_000, 0.005)
        self.table, self.views = table, list(recording)
        self.camera, self.each = recording.camera, 360 / len(recording)

    def describe(self):
        return replace(super().describe(), camera=self.camera)

    def frames(self) -> Iterator[SourceFrame]:
        for one in super().frames():
            standing = self.table.standing
            if standing is not None:
                view = self.views[round(standing / self.each) % len(self.views)]
                shown = {"depth": view.depth, "color": view.color, "raw": None, "host_time": time.time(), "log": {}}
                yield replace(one, **shown)


@pytest.mark.slow
def test_a_scan_uses_the_angles(tmp_path, capsys):
    """Frames of another turn than simulated would not agree with the log."""
    camera = {"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000}
    (tmp_path / "camera.json").write_text(json.dumps(camera | {"principle": "structured_light"}))
    words = f"--set frames=30 --set turns=1 --camera {tmp_path}/camera.json --seed 3 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(tmp_path / "turn")]) == 0
    with Emulated(speed=2000.0) as table:
        source = Turning(table, open_recording(tmp_path / "turn"))
        with Stepped(source, Grbl(table.name), 12.0, 0.0) as stepped:
            assert record_source(stepped, tmp_path / "rec").frames == 31
    capsys.readouterr()
    assert main(["turntable", str(tmp_path / "rec"), "-o", str(tmp_path / "out"), "--no-report", "--json"]) == 0
    found = json.loads((tmp_path / "out" / "turntable.json").read_text())
    turned = np.rad2deg(np.array(found["angles_rad"], float)) * found["direction"]
    np.testing.assert_allclose(turned, 12.0 * np.arange(31), atol=0.5)
    np.testing.assert_allclose(np.rad2deg(found["told_rad"]), 12.0 * np.arange(31), atol=0.01)


@pytest.mark.parametrize("how", [{"fault": "overhears"}, {"greets": False}, {"work": True}], ids=str)
def test_controllers_differ(how):
    with Emulated(**how) as table:
        turned = Grbl(table.name)
        assert [turned.go(angle) for angle in (0, -20, -40)] == pytest.approx([0, -20, -40], abs=1e-3)
        assert table.standing == pytest.approx(-40)
        turned.close()


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("mute", r"nothing there speaks GRBL; in /dev/pts/\d+; found no answer; expected Grbl 1.1; look whether"),
        ("talker", r"nothing there speaks GRBL; .*found '\$GPGGA"),
        ("locked", r"the table is not ready; .*found state Alarm; expected state Idle; .*unlock"),
        ("inches", r"the table reports in inches; .*set \$13=0"),
    ],
)
def test_a_table_that_is_not_ready_is_one_line_and_nothing_is_written(fault, told, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(opening, "open_source", lambda *_: MadeUp(100_000, 0.005, now=True))
    with Emulated(fault) as table:
        status = main(["record", "kinect-v1", "-o", str(tmp_path / "rec"), "--table", f"grbl:{table.name}"])
    err = capsys.readouterr().err
    assert status == 1
    assert err.count("\n") == 1
    assert re.search(told, err), err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("fault", "told", "kept"),
    [
        ("refuses", "the table refused a command; .*found error:15", 0),
        ("stuck", "the table does not get where it is sent; .*found state Idle at 0.00 deg; expected 60.00 deg", 1),
        ("alarm", "the table is in alarm; .*found (ALARM:1|state Alarm)", 2),
        ("freeze", "the table does not answer any more; .*found nothing for 0.5 s", 2),
        ("unplug", "the table is gone; .*plug it in again", 2),
        ("reset", "the table was reset while it turned", 2),
    ],
)
def test_a_table_that_fails_is_one_line_and_what_was_recorded_is_whole(
    fault, told, kept, tmp_path, capsys, monkeypatch
):
    out = tmp_path / "rec"
    with Emulated(fault, speed=600.0) as table:
        monkeypatch.setattr(opening, "open_source", lambda *_: Watching(table))
        words = ["record", "kinect-v1", "-o", str(out), "--table", f"grbl:{table.name}", "--step", "60"]
        status = main([*words, "--settle", "0.01"])
    err = capsys.readouterr().err
    assert status == 1
    assert err.count("\n") == 1
    assert re.search(told, err), err
    if kept:
        assert f"the {kept} frames before are kept in {out}" in err
        assert len(open_recording(out)) == kept
        assert not open_recording(out).warnings
    else:
        assert not list(tmp_path.iterdir())


def test_ports_and_tables_that_are_none_are_one_line(tmp_path):
    for name, told in (
        ("grbl:/dev/nowhere", "port cannot be opened; in /dev/nowhere; found No such file or directory"),
        (f"grbl:{tmp_path}", "port cannot be opened"),
        ("turntable", "there is no such table"),
        ("turn it", "does not say where to turn"),
        ("turn '{angle}", "cannot be taken apart"),
    ):
        with pytest.raises(DeviceError, match=told):
            open_table(name)


def test_without_pyserial_it_is_told_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(DeviceError, match=r"fusion-scan\[table\]"):
        open_table("grbl:/dev/ttyUSB0")


def test_a_stop_by_hand_stops_the_table_too(tmp_path):
    def stop_under_way() -> None:
        while table.standing is not None and not table.dead.is_set():
            time.sleep(0.02)
        source.stop()

    with Emulated(speed=1.0) as table:
        source = Stepped(MadeUp(100_000, 0.005, now=True), Grbl(table.name), 90.0, 0.0)
        threading.Thread(target=stop_under_way, daemon=True).start()
        begin = time.monotonic()
        with source:
            assert record_source(source, tmp_path / "rec").frames == 1
        assert time.monotonic() - begin < 10  # of 90 s that the move would take
        while not table.cancelled and time.monotonic() - begin < 20:  # the table reads what it was told a little later
            time.sleep(0.02)
        assert table.cancelled
        assert table.standing is not None


def test_a_command_is_run_for_each_place(tmp_path):
    log = tmp_path / "log"
    append = f"import sys; open({str(log)!r}, 'a').write(sys.argv[1] + ' ')"
    table = Command(f'{sys.executable} -c "{append}" {{angle}}')
    assert [table.go(angle) for angle in (0.0, 12.5, 25.0)] == [0.0, 12.5, 25.0]
    assert log.read_text().split() == ["0.0000", "12.5000", "25.0000"]
    log.unlink()
    steps = Command(f'{sys.executable} -c "{append}" by={{step}}')
    for angle in (0.0, 12.5, 25.0):
        steps.go(angle)
    assert log.read_text().split() == ["by=12.5000", "by=12.5000"]  # none at the start: it stands there


def test_a_command_that_fails_is_one_line(tmp_path):
    with pytest.raises(DeviceError, match=r"cannot be run; in no-such-table 0.0000; found No such file"):
        Command("no-such-table {angle}").go(0.0)
    fails = Command(f"{sys.executable} -c \"import sys; sys.exit('motor is hot')\" {{angle}}")
    with pytest.raises(DeviceError, match=r"command failed; .*found status 1, motor is hot"):
        fails.go(0.0)


def test_a_command_that_hangs_ends_with_the_recording():
    table = Command(f'{sys.executable} -c "import time; time.sleep(60)" {{angle}}')
    threading.Timer(0.5, table.stop).start()
    begin = time.monotonic()
    table.go(0.0)
    assert time.monotonic() - begin < 20


def test_options_of_a_table_without_one_are_told(tmp_path, capsys):
    assert main(["record", "replay:nothing", "-o", str(tmp_path / "rec"), "--settle", "1"]) == 1
    assert "there is no table to turn; in --settle; name it: --table grbl:PORT" in capsys.readouterr().err


def test_ctrl_c_in_the_middle_keeps_what_there_is(tmp_path):
    program = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in what a shell runs in the background
sys.path.insert(0, sys.argv[1])
from made_up_kinect import MadeUp
from fusion.devices import open as opening
opening.open_source = lambda name, camera=None, infrared=False: MadeUp(100_000, 0.005, now=True)
from fusion.commands.console import run
sys.argv = ["fusion", "record", "kinect-v1", "-o", sys.argv[2], *sys.argv[3:]]
raise SystemExit(run())
"""
    out = tmp_path / "rec"
    with Emulated() as table:
        words = [sys.executable, "-c", program, HERE, str(out), "--table", f"grbl:{table.name}", "--step", "1"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            end = time.monotonic() + 60
            while not (out / "depth" / "000002.png").exists():
                assert process.poll() is None, process.communicate()
                assert time.monotonic() < end
                time.sleep(0.02)
            process.send_signal(signal.SIGINT)
            said, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "stopped by hand" in said
    recording = open_recording(out)
    np.testing.assert_allclose(recording.telemetry_at_frames("turntable_deg"), np.arange(len(recording)), atol=0.01)


def test_driver_and_emulator_share_nothing():
    text = (Path(HERE) / "grbl_emulator.py").read_text()
    assert "import fusion" not in text
    assert "from fusion" not in text
    assert frame(0).index == 0
    assert os.name == "posix"
