"""Starts the emulator, and programs that see its devices; for tests, none of the project's code."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

EMULATOR = Path(__file__).parent / "emulator" / "kinect_v1.py"
PYTHON = "/usr/bin/python3"
PRELOAD = "libumockdev-preload.so.0"


def missing() -> str:
    """Why the emulator cannot run here; empty where it can."""
    asked = "import gi; gi.require_version('UMockdev', '1.0'); from gi.repository import UMockdev"
    if not shutil.which("umockdev-wrapper") or not Path(PYTHON).exists():
        return "no umockdev here: apt-get install umockdev gir1.2-umockdev-1.0 python3-gi libusb-1.0-0"
    if subprocess.run([PYTHON, "-c", asked], capture_output=True).returncode:
        return "the system's Python has no UMockdev: apt-get install gir1.2-umockdev-1.0 python3-gi"
    return ""


@contextmanager
def kinect(*options: str) -> Iterator[dict[str, str]]:
    """The environment in which a program sees the emulated Kinect, which goes with the block."""
    process = subprocess.Popen([PYTHON, str(EMULATOR), *options], stdout=subprocess.PIPE, text=True)
    try:
        line = process.stdout.readline()
        assert line.startswith("UMOCKDEV_DIR="), f"the emulator said {line!r}"
        folder = line.strip().partition("=")[2]
        yield {**os.environ, "UMOCKDEV_DIR": folder, "LD_PRELOAD": PRELOAD}
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


def run(program: str, environment: dict[str, str], timeout: float = 60) -> str:
    """What a Python program prints that sees the devices."""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=timeout)
    assert done.returncode == 0, done.stderr
    return done.stdout
