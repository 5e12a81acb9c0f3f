"""A command for tests of batches, quick and with habits of its own: what a recording's file says, it does.

good: writes its output. bad: refuses. full: finds no room on the disk. spin S: computes for S seconds of the processor.
kill: kills the worker the first time. sleep: takes long. hog: takes memory. crash: dies. Every beginning is a line in
runs.log beside the recordings.
"""

import errno
import json
import os
import signal
import sys
import time
from pathlib import Path

from fusion.errors import FusionError
from fusion.files.output.refused import told


def run(words: list[str]) -> int:
    """`do REC OUT`: the exit status."""
    given, out = Path(words[1]), Path(words[2])
    habit = (given / "habit.txt").read_text().split()
    with (given.parent / "runs.log").open("a") as log:
        log.write(f"{given.name}\n")
    if habit[0] == "bad":
        sys.stderr.write("fusion do: the recording is broken; in it\n")
        return 1
    if habit[0] == "full":
        try:
            with told(out):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except FusionError as error:
            sys.stderr.write(f"fusion do: {error}\n")
            return 1
    if habit[0] == "kill" and not (given.parent / f".{given.name}.killed").exists():
        (given.parent / f".{given.name}.killed").touch()
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    if habit[0] == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if habit[0] == "sleep":
        time.sleep(60)
    if habit[0] == "hog":
        kept = [bytearray(os.urandom(1 << 20)) for _ in range(400)]
        time.sleep(60 + len(kept))
    end = time.process_time() + (float(habit[1]) if habit[0] == "spin" else 0.0)
    total = 0
    while time.process_time() < end:
        total += 1
    made = out.with_name(f".making-{out.name}")
    made.mkdir()
    (made / "result.json").write_text(json.dumps({"size": len(given.name), "name": given.name}))
    made.rename(out)
    return 0
