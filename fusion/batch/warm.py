"""The warm process of a worker: asked for one command after another, watched, and replaced when it is stopped."""

import json
import os
import select
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from threading import local
from typing import Any

from fusion.batch.job import JobLimits

LOOK_S = 0.05  # how often memory and time are looked at
_own = local()  # a process for each of a worker's threads: one Taichi in a process


@dataclass(frozen=True)
class Answer:
    """How a command ended."""

    status: int | None  # its exit status; None where its process was stopped or died
    said: str  # what it printed, or why it was stopped
    seconds: float  # it ran; of the clock
    gigabytes: float = 0.0  # the most memory that was seen


class Warm:
    """One process that runs commands."""

    def __init__(self, runner: str) -> None:
        self.runner = runner
        command = [sys.executable, "-m", "fusion.batch.child", runner]
        # a session of its own: Ctrl-C is for whoever asked, and its end is the end of this
        self._process = subprocess.Popen(
            command,
            bufsize=0,  # of a process that died nothing is left to be written
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def run(self, words: list[str], home: str, limits: JobLimits) -> Answer:
        """Run a command to its end, or to its limits."""
        assert self._process.stdin is not None
        begun, most = time.monotonic(), 0.0
        with suppress(BrokenPipeError):
            self._process.stdin.write((json.dumps({"words": words, "home": home}) + "\n").encode())
            self._process.stdin.flush()
        while not self._answered():
            seconds = time.monotonic() - begun
            if limits.seconds is not None and seconds > limits.seconds:
                self.stop()
                return Answer(None, f"it took longer than {limits.seconds:g} s and was stopped", seconds, most)
            if limits.gigabytes is not None:
                most = max(most, self.gigabytes())
                if most > limits.gigabytes:
                    self.stop()
                    told = f"it took more than {limits.gigabytes:g} GB of memory and was stopped"
                    return Answer(None, told, seconds, most)
        return self._answer(time.monotonic() - begun, most)

    def stop(self) -> None:
        """End the process, whatever it does."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, 9)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()

    def gigabytes(self) -> float:
        """Memory of the process and of those that it started."""
        import psutil

        total = 0
        with suppress(psutil.Error):
            process = psutil.Process(self._process.pid)
            for one in (process, *process.children(recursive=True)):
                with suppress(psutil.Error):
                    total += one.memory_info().rss
        return total / 1e9

    def _answered(self) -> bool:
        """True when there is something to read, or nothing will come any more."""
        assert self._process.stdout is not None
        return bool(select.select([self._process.stdout], [], [], LOOK_S)[0])

    def _answer(self, seconds: float, most: float) -> Answer:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            status = self._process.wait()
            self.stop()
            how = f"signal {-status}" if status < 0 else f"status {status}"
            return Answer(None, f"its process died ({how})", seconds, most)
        told: dict[str, Any] = json.loads(line)
        return Answer(int(told["status"]), str(told["said"]), float(told["seconds"]), most)


def run_warm(words: list[str], home: str, runner: str, limits: JobLimits) -> Answer:
    """Run a command in this thread's warm process, which is made when there is none."""
    warm: Warm | None = getattr(_own, "warm", None)
    if warm is not None and (not warm.alive or warm.runner != runner):
        warm.stop()
        warm = None
    if warm is None:
        warm = _own.warm = Warm(runner)
    answer = warm.run(words, home, limits)
    # what a library keeps is not the next job's fault
    if limits.gigabytes is not None and warm.alive and warm.gigabytes() > limits.gigabytes / 2:
        warm.stop()
    return answer
