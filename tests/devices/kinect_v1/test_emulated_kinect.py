"""The driver with real pyusb, libusb1 and libusb against the emulated Kinect, which was written apart from it.

The emulator is a process of its own, started by its command line; neither side imports anything of the other.
"""

import ast
import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fusion.recording.open import open_recording

HERE = Path(__file__).resolve().parent
EMULATOR = HERE.parent / "emulator" / "kinect_v1.py"
DRIVER = HERE.parents[2] / "fusion" / "devices"
RECORD = "from fusion.commands.console import run; raise SystemExit(run())"


@contextlib.contextmanager
def emulated(*words):
    """The environment in which a program sees the camera."""
    pytest.importorskip("usb.core", reason="pyusb, of the extra kinect, is not installed")
    pytest.importorskip("usb1", reason="libusb1, of the extra kinect, is not installed")
    command = ["/usr/bin/python3", str(EMULATOR), *words]
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    except OSError:
        pytest.skip("no /usr/bin/python3 here")
    line = process.stdout.readline()
    if not line.startswith("UMOCKDEV_DIR="):
        pytest.skip(f"the emulator does not start: {process.communicate()[1][-200:]}")
    try:
        yield os.environ | {"UMOCKDEV_DIR": line.strip().partition("=")[2], "LD_PRELOAD": "libumockdev-preload.so.0"}
    finally:
        process.kill()
        process.communicate()


def recorded(folder, around, *words):
    command = [sys.executable, "-c", RECORD, "record", "kinect-v1", "-o", str(folder), "--quiet", "--color", "jpeg"]
    return subprocess.run([*command, *words], env=around, capture_output=True, text=True, timeout=120)


def test_driver_and_emulator_share_no_code():
    for path in EMULATOR.parent.glob("*.py"):
        imported = [
            node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Import | ast.ImportFrom)
        ]
        for node in imported:
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
            assert not any(name.split(".")[0] in ("fusion", "usb", "usb1", "fake_usb") for name in names)
    for path in DRIVER.rglob("*.py"):
        assert "emulator" not in path.read_text()


@pytest.mark.slow
def test_no_frame_is_lost_and_each_has_its_picture(tmp_path):
    with emulated() as around:
        done = recorded(tmp_path / "rec", around, "--frames", "150")
    assert done.returncode == 0, done.stderr
    assert "150 frames in" in done.stdout
    recording = open_recording(tmp_path / "rec")
    assert recording.telemetry["missed"][1:].sum() == recording.telemetry["lost_bytes"].sum() == 0
    assert recording.camera.fx == pytest.approx(575.8, rel=0.05)
    assert sum(recording.color_apart(i) is not None for i in range(150)) > 120


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "column"),
    [("lost", "lost_bytes"), ("short", "lost_bytes"), ("packet-error", "lost_bytes"), ("burst", "missed")],
)
def test_what_did_not_come_is_counted(fault, column, tmp_path):
    with emulated("--fault", fault) as around:
        done = recorded(tmp_path / "rec", around, "--frames", "90")
    assert done.returncode == 0, done.stderr
    counted = open_recording(tmp_path / "rec").telemetry[column]
    assert 7 <= (counted > 0).sum() <= 12  # every tenth frame of 90 and more


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["stall", "mute", "reply-magic"])
def test_a_camera_that_does_not_obey_is_one_line(fault, tmp_path):
    with emulated("--fault", fault) as around:
        done = recorded(tmp_path / "rec", around, "--frames", "30")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "rec").exists()


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["unplug", "silent"])
def test_a_camera_that_comes_back_goes_on(fault, tmp_path):
    with emulated("--fault", fault) as around:
        done = recorded(tmp_path / "rec", around, "--frames", "120")
    assert done.returncode == 0, done.stderr
    recording = open_recording(tmp_path / "rec")
    assert len(recording) == 120
    assert not recording.warnings
    assert (recording.timestamps[1:] > recording.timestamps[:-1]).all()
    if fault == "unplug":
        assert recording.telemetry["missed"].max() >= 30  # 1.5 s and more
