"""A process that runs one command after another and stays warm: libraries loaded, kernels compiled.

    python -m fusion.batch.child module:function

Requests come as lines of JSON: {"words": [...], "home": FOLDER}; an answer is one too: {"status": N, "said": TEXT,
"seconds": S}. Where whoever asks is gone, the process ends at once.
"""

import importlib
import json
import os
import queue
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import IO

from fusion.compute.process import tune_process
from fusion.progress import leave_out_times

TOLD = 4000  # characters of what a command says that are handed on: its last lines
GONE = 3  # status of a process whose asker is gone


@dataclass(frozen=True)
class Request:
    """What is to be run."""

    words: list[str]  # of the command
    home: str  # folder that it runs in


def main() -> None:
    """Answer requests until there are no more."""
    tune_process()
    leave_out_times()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("TQDM_DISABLE", "1")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    waiting: queue.Queue[Request] = queue.Queue()
    threading.Thread(target=_listen, args=(os.fdopen(os.dup(0), encoding="utf-8"), waiting), daemon=True).start()
    module, _, name = sys.argv[1].partition(":")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)  # no command reads what is meant for this loop
    while True:
        request = waiting.get()
        begun = time.perf_counter()
        status, said = _run(module, name, request)
        answer = {"status": status, "said": said, "seconds": time.perf_counter() - begun}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _listen(requests: IO[str], waiting: "queue.Queue[Request]") -> None:
    for line in requests:
        waiting.put(Request(**json.loads(line)))
    os._exit(GONE)


def _run(module: str, name: str, request: Request) -> tuple[int, str]:
    """Exit status of a command, and what it said."""
    with tempfile.TemporaryFile() as told:
        os.dup2(told.fileno(), 1)
        os.dup2(told.fileno(), 2)
        sys.argv = ["fusion", *request.words]  # results tell how they were made
        try:
            os.chdir(request.home)
            run: Callable[[list[str]], int] = getattr(importlib.import_module(module), name)
            status = int(run(request.words) or 0)
        except SystemExit as stop:
            status = stop.code if isinstance(stop.code, int) else 1
        except BaseException:
            traceback.print_exc()
            status = 1
        sys.stdout.flush()
        sys.stderr.flush()
        size = told.seek(0, os.SEEK_END)
        told.seek(max(0, size - TOLD))
        return status, told.read().decode("utf-8", "replace")


if __name__ == "__main__":
    main()
