"""Ctrl-C while frames are recorded is a flag: lost nowhere, and nothing is cut in two by it."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from fusion.devices.by_hand import by_hand
from fusion.recording.open import open_recording

HERE = str(Path(__file__).resolve().parent)


@pytest.fixture
def default_handlers():
    """As a program of a user's own has them."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def press(number: int = signal.SIGINT) -> None:
    os.kill(os.getpid(), number)


@pytest.mark.usefixtures("default_handlers")
def test_the_first_sets_a_flag_and_the_second_ends_at_once():
    with by_hand() as hand:
        assert not hand.asked
        press()
        assert hand.asked
        with pytest.raises(KeyboardInterrupt):
            press()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with pytest.raises(KeyboardInterrupt):  # and what it would have done without
        hand.pass_on()


def test_what_is_ignored_stays_ignored_and_other_threads_change_nothing():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with by_hand() as hand:
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            press(signal.SIGHUP)
            assert not hand.asked
    finally:
        signal.signal(signal.SIGHUP, before)
    kept, seen = signal.getsignal(signal.SIGINT), []

    def elsewhere() -> None:
        with by_hand():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [kept]


RECORDER = """
import os, signal, sys, threading
sys.path.insert(0, sys.argv[1])
signal.signal(signal.SIGINT, signal.default_int_handler)
from made_up_kinect import MadeUp
from fusion.devices.record import record_source
source, moment = MadeUp(100_000, 0.001), int(sys.argv[3])
count = 0
def between(frame, event, argument):
    global count
    if frame.f_code.co_filename != threading.__file__ or source.given < 5:
        return between
    count += 1
    if count == moment:
        os.kill(os.getpid(), signal.SIGINT)
    return between
sys.settrace(between)
done = record_source(source, sys.argv[2])
sys.settrace(None)
assert count >= moment
print(done.ended, done.frames)
"""


@pytest.mark.parametrize("moment", [1, 2, 4, 11, 13, 20])
def test_ctrl_c_between_any_two_steps_of_a_wait_ends_a_recording_whole(moment, tmp_path):
    """An exception raised there may leave a lock taken that the writer needs: 4 of 30 moments did not end, 3 failed."""
    command = [sys.executable, "-c", RECORDER, HERE, str(tmp_path / "rec"), str(moment)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    ended, frames = done.stdout.split()
    assert ended == "stopped"
    assert len(open_recording(tmp_path / "rec")) == int(frames) >= 5


def test_a_camera_that_never_lets_go_does_not_keep_the_process():
    """libusb's own end waits without limit where a device went away in the middle of a call."""
    pytest.importorskip("usb1")
    program = f"""
import sys, time, weakref
sys.path.insert(0, {HERE!r})
from types import SimpleNamespace
from fusion.commands.console import run
from fusion.commands.catalogue import COMMANDS
class Thing:
    pass
def work(options):
    import usb1
    global thing
    thing = Thing()
    weakref.finalize(thing, time.sleep, 60)
    print("told")
COMMANDS["try"] = "nothing"
sys.modules["fusion.commands.try"] = SimpleNamespace(EXAMPLE="", add_arguments=lambda parser: None, run=work)
raise SystemExit(run())
"""
    begin = time.monotonic()
    done = subprocess.run([sys.executable, "-c", program, "try"], capture_output=True, text=True, timeout=50)
    assert (done.returncode, done.stdout, done.stderr) == (0, "told\n", "")
    assert time.monotonic() - begin < 30
