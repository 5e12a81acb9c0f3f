"""Work done by a process of its own: results, failures, and what becomes of it when a process is killed."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest

from fusion.live.aside import Aside


def test_the_work_is_done_elsewhere():
    with Aside() as aside:
        first, second = aside.submit(os.getpid), aside.submit(np.add, np.ones(1_000_000), 1.0)
        assert first.result(30) != os.getpid()
        assert (second.result(30) == 2).all()


def test_what_goes_wrong_there_is_raised_here_and_the_next_is_done():
    with Aside() as aside:
        with pytest.raises(ValueError, match="invalid literal"):
            aside.submit(int, "five").result(30)
        assert aside.submit(os.getpid).result(30) != os.getpid()


def test_a_killed_process_is_done_without():
    with Aside() as aside:
        os.kill(aside.submit(os.getpid).result(30), signal.SIGKILL)
        assert aside.submit(os.getpid).result(30) == os.getpid()


def test_a_program_that_cannot_be_started_is_done_without(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with Aside() as aside:
        assert aside.submit(os.getpid).result(30) == os.getpid()


def test_work_under_way_is_given_up_at_the_end():
    begin = time.monotonic()
    with Aside() as aside:
        aside.submit(os.getpid).result(30)
        waiting = aside.submit(time.sleep, 60)
        while not waiting.running():  # else it is cancelled before it is under way
            time.sleep(0.01)
    assert time.monotonic() - begin < 30
    assert isinstance(waiting.exception(1), CancelledError)


def test_it_ends_with_whoever_began_it():
    """Also where that is killed and can say nothing."""
    code = "import os, time; from fusion.live.aside import Aside; print(Aside().submit(os.getpid).result(), flush=True)"
    with subprocess.Popen([sys.executable, "-c", f"{code}; time.sleep(60)"], stdout=subprocess.PIPE) as program:
        assert program.stdout is not None
        number = int(program.stdout.readline())
        program.kill()
    end = time.monotonic() + 10
    while time.monotonic() < end and _alive(number):
        time.sleep(0.05)
    assert number != program.pid and not _alive(number)


def _alive(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
