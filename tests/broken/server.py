"""A process that has imported the program once and forks for every case, so that a case costs its own work only.

`python -m broken.server FD`: a request is one line of JSON on the socket FD, its answer another; see `runner.py`.
"""

import atexit
import contextlib
import ctypes
import json
import os
import pkgutil
import resource
import signal
import socket
import struct
import sys
import tempfile
import time
import traceback
from pathlib import Path

# what a program that keeps to itself never does; names of CPython's audit events
REACHING = (
    "socket.connect",
    "socket.bind",
    "socket.getaddrinfo",
    "socket.sendto",
    "subprocess.Popen",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "pickle.find_class",
    "webbrowser.open",
    "ftplib.connect",
    "urllib.Request",
)
TICKS = os.sysconf("SC_CLK_TCK")
LIMIT_FILE = 4 << 30  # a flood of the disk ends here


def load() -> None:
    """Import all that any command may import."""
    import importlib

    import fusion

    for found in pkgutil.walk_packages(fusion.__path__, "fusion."):
        try:
            importlib.import_module(found.name)
        except (ImportError, fusion.FusionError):  # of an extra that is not installed
            continue
    for name in (
        "open3d",
        "taichi",
        "cv2",
        "scipy.optimize",
        "scipy.spatial",
        "trimesh",
        "matplotlib.pyplot",
        "numpy.lib.npyio",
    ):
        importlib.import_module(name)


def be_nobody_special() -> None:
    """Root reads and writes what has no right for it; without its powers it is held to them."""
    if os.geteuid() == 0:
        header = struct.pack("<Ii", 0x20080522, 0)
        if ctypes.CDLL(None, use_errno=True).capset(header, bytes(24)) != 0:
            raise OSError(ctypes.get_errno(), "capset")


def watch(events: Path) -> None:
    """Note every event that reaches out of the process, from now on."""

    def hear(event: str, arguments: tuple) -> None:
        if event in REACHING:
            with open(events, "a", encoding="utf-8") as file:  # noqa: PTH123  a hook that is called anywhere: the least
                file.write(f"{event} {str(arguments)[:200]!r}\n")

    sys.addaudithook(hear)


def act(request: dict) -> int:
    """In the child: be a new process that was started as `fusion WORDS`; returns its exit status."""
    os.setsid()
    for number, name in enumerate(("/dev/null", request["stdout"], request["stderr"])):
        flags = os.O_RDONLY if number == 0 else os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        opened = os.open(name, flags, 0o600)
        os.dup2(opened, number)
        os.close(opened)
    os.chdir(request["folder"])
    os.environ["TMPDIR"] = request["scratch"]
    tempfile.tempdir = None
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT_FILE, LIMIT_FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    be_nobody_special()
    watch(Path(request["events"]))
    sys.argv = ["fusion", *request["words"]]
    from fusion.commands.console import run

    try:
        ended = run()
    except SystemExit as end:
        ended = end.code
    if ended is None or isinstance(ended, int):
        return ended or 0
    print(ended, file=sys.stderr)  # noqa: T201  as the interpreter does
    return 1


def child(request: dict) -> None:
    """Run, end the interpreter's way, never return."""
    status = 70
    try:
        status = act(request)
    except BaseException:
        traceback.print_exc()
        status = 1
    finally:
        try:
            atexit._run_exitfuncs()
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(status & 255)


def resident(pid: int) -> int:
    """Bytes of memory that a process holds now; 0 when it has ended."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()
    except (OSError, IndexError, ValueError):
        return 0


def work(pid: int) -> tuple[str, int]:
    """A process's state, R where it is ready to run, and the ticks of processor time that it has used."""
    try:
        state, *rest = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    except (OSError, IndexError):
        return "", 0
    return state, int(rest[10]) + int(rest[11])


def follow(pid: int, request: dict) -> dict:
    """Wait for the child, end it where it takes too long or too much; what became of it."""
    start, peak, why = time.monotonic(), 0, ""
    worked, since = 0, start  # ticks of work done, and when that last grew
    while True:
        done, status, used = os.wait4(pid, os.WNOHANG)
        if done:
            break
        peak = max(peak, resident(pid))
        if peak > request["limit_bytes"]:
            why = "memory"
        now, (state, ticks) = time.monotonic(), work(pid)
        if ticks > worked or state == "R":
            worked, since = ticks, now
        # cores are shared: work is what counts, and waiting where it is endless
        if (
            worked / TICKS > request["limit_s"]
            or now - since > request["idle_s"]
            or now - start > 10 * request["limit_s"]
        ):
            why = "time"
        if why:
            os.kill(pid, signal.SIGKILL)
            _, status, used = os.wait4(pid, 0)
            break
        time.sleep(0.005)
    seconds = time.monotonic() - start
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)  # nothing that it started lives on
    peak = max(peak, used.ru_maxrss * 1024)
    cpu = used.ru_utime + used.ru_stime
    return {"status": os.waitstatus_to_exitcode(status), "seconds": seconds, "cpu": cpu, "peak": peak, "ended": why}


def serve(channel: socket.socket) -> None:
    """Answer requests until the channel closes."""
    with channel.makefile("r", encoding="ascii") as lines:
        for line in lines:
            request = json.loads(line)
            pid = os.fork()
            if pid == 0:
                channel.close()
                child(request)
            channel.sendall(json.dumps(follow(pid, request)).encode() + b"\n")


if __name__ == "__main__":
    load()
    given = socket.socket(fileno=int(sys.argv[1]))
    given.sendall(b'"ready"\n')
    serve(given)
