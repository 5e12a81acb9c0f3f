"""Stops a function at its n-th file operation, from outside: the kernel tells of each before it takes place.

The function runs in a forked child under a seccomp filter that hands every call which changes files to this process
(seccomp_unotify(2)). Nothing in the code under test is replaced, and calls of C libraries are seen as well.
"""

import ctypes
import errno
import fcntl
import os
import platform
import select
import signal
import socket
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

# x86_64: call, and which of its arguments name a file: ("fd", n), ("path", n) or ("at", n) for a folder and a name
CALLS = {
    1: ("write", [("fd", 0)]),
    18: ("pwrite64", [("fd", 0)]),
    20: ("writev", [("fd", 0)]),
    296: ("pwritev", [("fd", 0)]),
    40: ("sendfile", [("fd", 0)]),
    326: ("copy_file_range", [("fd", 2)]),
    77: ("ftruncate", [("fd", 0)]),
    285: ("fallocate", [("fd", 0)]),
    91: ("fchmod", [("fd", 0)]),
    76: ("truncate", [("path", 0)]),
    82: ("rename", [("path", 0), ("path", 1)]),
    264: ("renameat", [("at", 0), ("at", 2)]),
    316: ("renameat2", [("at", 0), ("at", 2)]),
    83: ("mkdir", [("path", 0)]),
    258: ("mkdirat", [("at", 0)]),
    84: ("rmdir", [("path", 0)]),
    87: ("unlink", [("path", 0)]),
    263: ("unlinkat", [("at", 0)]),
    86: ("link", [("path", 0), ("path", 1)]),
    265: ("linkat", [("at", 0), ("at", 2)]),
    88: ("symlink", [("path", 1)]),
    266: ("symlinkat", [("at", 1)]),
    90: ("chmod", [("path", 0)]),
    268: ("fchmodat", [("at", 0)]),
    85: ("creat", [("path", 0)]),
    2: ("open", [("path", 0)]),
    257: ("openat", [("at", 0)]),
}
OPENS = {2: 1, 257: 2}  # only those that write: which argument holds the flags
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
GIVING_BACK = {"rmdir", "unlink", "unlinkat"}  # what works on a full disk
SECCOMP, ARCHITECTURE, NOTIFY, ALLOW = 317, 0xC000003E, 0x7FC00000, 0x7FFF0000
RECEIVE, SEND = 0xC0502100, 0xC0182101  # ioctl
AT_FDCWD = -100
LIMIT = 120.0  # [s] that a child may take


@dataclass
class Ran:
    """What became of a run.

    Attributes:
        status: exit status, negative for a signal.
        said: on stderr.
        operations: those on files in the folder, each as its name and files, up to the stop or the end.
    """

    status: int
    said: str
    operations: list[str] = field(default_factory=list)


def available() -> bool:
    """Whether this system can tell of calls."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return False
    try:
        return run_stopped(lambda: 0, Path("/nowhere"), 0, "killed").status == 0
    except OSError:
        return False


def run_stopped(work: Callable[[], int], folder: Path, number: int, how: str) -> Ran:
    """Run `work` in a child and stop it at its `number`-th operation (from 1; 0: never) on files in `folder`.

    Args:
        work: returns an exit status.
        folder: without links.
        number: which operation.
        how: "killed" (before it), "full" (it fails, and every later one that needs room), "terminated" (SIGTERM).
    """
    ours, theirs = socket.socketpair()
    told = os.memfd_create("stderr")
    child = os.fork()
    if child == 0:
        _child(work, ours, theirs, told)
    theirs.close()
    try:
        with ours:
            _, handles, *_ = socket.recv_fds(ours, 1, 1)
        if not handles:
            raise OSError("no filter in this system")
        operations = _supervise(handles[0], child, folder, number, how)
        os.close(handles[0])
    finally:
        _, status = os.waitpid(child, 0)
        os.lseek(told, 0, os.SEEK_SET)
        said = os.read(told, 1 << 20).decode()
        os.close(told)
    return Ran(os.waitstatus_to_exitcode(status), said, operations)


def _child(work: Callable[[], int], ours: socket.socket, theirs: socket.socket, told: int) -> None:
    status = 99
    try:
        ours.close()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(told, 2)
        sys.stdout, sys.stderr = os.fdopen(1, "w", closefd=False), os.fdopen(2, "w", closefd=False)
        listener = _filter()
        socket.send_fds(theirs, [b"x"], [listener])
        os.close(listener)
        theirs.close()
        status = work()
        sys.stdout.flush()
        sys.stderr.flush()
    except BaseException:
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(status)


def _filter() -> int:
    """Put this process under the filter; the handle that its calls are told by."""
    code = [(0x20, 0, 0, 4), (0x15, 1, 0, ARCHITECTURE), (0x06, 0, 0, ALLOW), (0x20, 0, 0, 0)]
    for call in CALLS:
        if call in OPENS:
            flags = 16 + 8 * OPENS[call]
            code += [(0x15, 0, 4, call), (0x20, 0, 0, flags), (0x45, 0, 1, WRITING), (0x06, 0, 0, NOTIFY)]
            code += [(0x06, 0, 0, ALLOW)]
        else:
            code += [(0x15, 0, 1, call), (0x06, 0, 0, NOTIFY)]
    code += [(0x06, 0, 0, ALLOW)]
    program = b"".join(struct.pack("HBBI", *one) for one in code)
    buffer = ctypes.create_string_buffer(program)
    head = ctypes.create_string_buffer(struct.pack("HxxxxxxQ", len(code), ctypes.addressof(buffer)))
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(38, 1, 0, 0, 0)  # PR_SET_NO_NEW_PRIVS: else only root may
    listener = libc.syscall(SECCOMP, 1, 8, head)
    if listener < 0:
        raise OSError(ctypes.get_errno(), "seccomp")
    return int(listener)


def _supervise(listener: int, child: int, folder: Path, number: int, how: str) -> list[str]:
    poll = select.poll()
    poll.register(listener, select.POLLIN)
    operations: list[str] = []
    while True:
        events = poll.poll(LIMIT * 1000)
        if not events:
            os.kill(child, signal.SIGKILL)
            raise TimeoutError(f"no call in {LIMIT} s, after {operations[-5:]}")
        if not events[0][1] & select.POLLIN:
            return operations
        call = bytearray(80)
        try:
            fcntl.ioctl(listener, RECEIVE, call)
        except FileNotFoundError:  # the child died meanwhile
            continue
        key, thread = struct.unpack_from("QI", call)
        name, files = _told(thread, *struct.unpack_from("i12x6Q", call, 16))
        failed = 0
        if any(Path(file).is_relative_to(folder) for file in files):
            operations.append(f"{name} {' '.join(os.path.relpath(file, folder) for file in files)}")
            here, after = len(operations) == number, 0 < number < len(operations)
            if here and how == "killed":
                os.kill(child, signal.SIGKILL)
                return operations
            if here and how == "terminated":
                os.kill(child, signal.SIGTERM)
            if how == "full" and (here or (after and name not in GIVING_BACK)):
                failed = -errno.ENOSPC
        try:
            fcntl.ioctl(listener, SEND, struct.pack("QqiI", key, 0, failed, 0 if failed else 1))
        except FileNotFoundError:
            continue


def _told(thread: int, call: int, *values: int) -> tuple[str, list[str]]:
    name, arguments = CALLS[call]
    return name, [_file(thread, kind, values, place) for kind, place in arguments]


def _file(thread: int, kind: str, values: tuple[int, ...], place: int) -> str:
    """The file that an argument names."""
    if kind == "fd":
        return _link(f"/proc/{thread}/fd/{values[place]}")
    where = ctypes.c_int(values[place]).value if kind == "at" else AT_FDCWD
    path = os.fsdecode(_text(thread, values[place + (kind == "at")]))
    base = _link(f"/proc/{thread}/cwd" if where == AT_FDCWD else f"/proc/{thread}/fd/{where}")
    return os.path.normpath(os.path.join(base, path))  # noqa: PTH118


def _link(path: str) -> str:
    try:
        return str(Path(path).readlink())
    except OSError:
        return "?"


def _text(thread: int, address: int) -> bytes:
    """A string in the memory of the child."""
    with open(f"/proc/{thread}/mem", "rb", buffering=0) as memory:  # noqa: PTH123
        memory.seek(address)
        text = memory.read(4096 - address % 4096)  # to the end of the page: the next one may not exist
        if b"\0" not in text:
            text += memory.read(4096)
    return text.split(b"\0")[0]
