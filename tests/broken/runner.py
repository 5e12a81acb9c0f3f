"""Runs a case and keeps what there was to see: exit status, output, time, memory, and the folder before and after."""

import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from broken.bases import PROGRAM
from broken.case import Case
from broken.server import follow
from broken.snapshot import Snapshot, snapshot

LIMIT_S = 30.0
IDLE_S = 8.0  # a process that waits so long without any work waits for what never comes
LIMIT_BYTES = 2_000_000_000
HERE = Path(__file__).resolve().parent
# the same on every machine, and cases run beside others
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "TI_CPU_MAX_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Ran:
    """What one run of the program did."""

    words: list[str]
    status: int  # negative: ended by that signal
    stdout: bytes
    stderr: bytes
    seconds: float
    cpu: float
    peak: int  # bytes resident at most
    ended: str  # "time" or "memory" where it was ended for that
    events: list[str]  # calls that reach out of the process
    before: Snapshot
    after: Snapshot
    folder: Path
    scratch: list[str]  # what is left in TMPDIR
    read_outside: list[str]  # files of the case's folder `outside` that were read; needs a disk that notes it


class Server:
    """A forking server of `server.py`."""

    def __init__(self) -> None:
        mine, its = socket.socketpair()
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE.parent), str(HERE.parent.parent)])}
        environment |= {"MPLBACKEND": "Agg", "COLUMNS": "120", **ONE_THREAD}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "broken.server", str(its.fileno())],
            env=environment,
            stdin=subprocess.DEVNULL,
            pass_fds=[its.fileno()],
        )
        its.close()
        self._channel = mine
        self._lines = mine.makefile("r", encoding="ascii")
        assert json.loads(self._lines.readline() or '""') == "ready", "the server did not start"

    def ask(self, request: dict) -> dict:
        """One run."""
        self._channel.sendall(json.dumps(request).encode() + b"\n")
        line = self._lines.readline()
        assert line, "the server has ended"
        return json.loads(line)

    def close(self) -> None:
        self._lines.close()
        self._channel.close()
        self.process.wait(timeout=60)


class Fresh:
    """A new process for every run, as a user starts it: slower, and nothing is there from before."""

    def ask(self, request: dict) -> dict:
        """One run."""
        environment = {
            **os.environ,
            "PYTHONPATH": str(HERE.parent.parent),
            "TMPDIR": request["scratch"],
            "MPLBACKEND": "Agg",
        }
        with Path(request["stdout"]).open("wb") as out, Path(request["stderr"]).open("wb") as err:
            child = subprocess.Popen(
                [sys.executable, "-c", PROGRAM, *request["words"]], cwd=request["folder"], env=environment,
                stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True,
            )  # fmt: skip
        answer = follow(child.pid, request)
        child.returncode = answer["status"]  # it has been waited for
        return answer


def keep_kernels(place: Path) -> None:
    """Let the program compile its kernels, once on a machine: a server's children end too soon to keep them."""
    words = ["demo", "-o", str(place / "kernels"), "--frames", "12", "--no-report"]
    subprocess.run(
        [sys.executable, "-c", PROGRAM, *words], env={**os.environ, **ONE_THREAD}, check=True, stdout=subprocess.DEVNULL
    )


def run(case: Case, server: Server | Fresh, place: Path) -> Ran:
    """Make the case's input in a new folder below `place`, run the program there, look before and after."""
    folder, beside = place / "case", place / "beside"
    scratch = beside / "scratch"
    folder.mkdir(parents=True)
    scratch.mkdir(parents=True)
    words = case.make(folder)
    return run_words(words, server, folder, beside)


def run_words(words: list[str], server: Server | Fresh, folder: Path, beside: Path) -> Ran:
    """Run `fusion WORDS` in a folder; files of the run itself go beside it."""
    before = snapshot(folder)
    scratch, events = beside / "scratch", beside / "events"
    _age(folder / "outside")
    request = {
        "words": words,
        "folder": str(folder),
        "scratch": str(scratch),
        "events": str(events),
        "stdout": str(beside / "stdout"),
        "stderr": str(beside / "stderr"),
        "limit_s": LIMIT_S * 1.1,
        "idle_s": IDLE_S,
        "limit_bytes": LIMIT_BYTES * 1.1,
    }
    answer = server.ask(request)
    read_outside = _since_aged(folder / "outside")
    return Ran(
        words=words,
        stdout=_read(beside / "stdout"),
        stderr=_read(beside / "stderr"),
        before=before,
        read_outside=read_outside,
        after=snapshot(folder),
        folder=folder,
        scratch=sorted(p.name for p in scratch.iterdir()),
        events=events.read_text(encoding="utf-8").splitlines() if events.exists() else [],
        **answer,
    )


def _age(folder: Path) -> None:
    """Say of every file that it was last read long ago: a disk mounted with relatime notes the next time."""
    for path in folder.rglob("*"):
        if path.is_file() and not path.is_symlink():
            os.utime(path, ns=(10**9, path.stat().st_mtime_ns))


def _since_aged(folder: Path) -> list[str]:
    files = [path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()]
    return sorted(f"outside/{path.name}" for path in files if path.stat().st_atime_ns != 10**9)


def _read(path: Path) -> bytes:
    return path.read_bytes()[:1_000_000] if path.exists() else b""


def forget(place: Path) -> None:
    """Remove a case's folders, whatever rights it took away."""
    for folder, _, _ in os.walk(place):
        with contextlib.suppress(OSError):
            Path(folder).chmod(0o700)
    shutil.rmtree(place, ignore_errors=True)


@contextlib.contextmanager
def serving() -> Iterator[Server]:
    """A server for as long as the block lasts."""
    server = Server()
    try:
        yield server
    finally:
        server.close()
