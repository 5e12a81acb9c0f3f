"""Work that a process of its own does, so that a view and a recorder need not wait for it.

A thread keeps them waiting: Python lets one thread at a time work, and numpy gives way between its steps only. A
process does not. It is started as a program, not by `multiprocessing`, which runs a user's own script once more.
"""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from typing import Any

PATIENCE = 2.0  # [s] for the process to end once nobody asks it any more


class Aside(Executor):
    """One piece of work after the other; its function, arguments and result go through pickle.

    Where there can be no such process, or it is killed, a thread does the work. It ends with this process, whatever
    ends that.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "fusion-aside")  # waits for the answers
        self._process: subprocess.Popen[bytes] | None = None
        self._over = False
        with contextlib.suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-m", "fusion.live.aside"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )

    def submit(self, work: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        """As any Executor."""
        return self._thread.submit(self._done, work, args, named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """As any Executor; work that is under way is given up."""
        self._over = True
        if self._process is not None:
            self._process.kill()
            self._process.wait(PATIENCE)
        self._thread.shutdown(wait, cancel_futures=True)
        for pipe in (self._process.stdin, self._process.stdout) if self._process is not None else ():
            with contextlib.suppress(OSError):
                assert pipe is not None
                pipe.close()

    def _done(self, work: Callable[..., Any], args: tuple[Any, ...], named: Mapping[str, object]) -> Any:
        try:
            assert self._process is not None and self._process.stdin is not None and self._process.stdout is not None
            pickle.dump((work, args, named), self._process.stdin, pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()
            went_well, result = pickle.load(self._process.stdout)
        except (AssertionError, OSError, EOFError, pickle.UnpicklingError):
            if self._over:
                raise CancelledError from None
            return work(*args, **named)
        if not went_well:
            raise result
        return result


def _serve() -> None:
    """Answer until nobody asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the recorder, which ends this when it is done
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    with contextlib.suppress(EOFError, OSError):
        while True:
            work, args, named = pickle.load(sys.stdin.buffer)
            try:
                answer = True, work(*args, **named)
            except Exception as error:
                answer = False, error
            pickle.dump(answer, answers, pickle.HIGHEST_PROTOCOL)
            answers.flush()


if __name__ == "__main__":
    _serve()
