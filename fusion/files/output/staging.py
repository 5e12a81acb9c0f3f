"""Places beside a result where it is made: `.partial-1234abcd/`, and how those of dead processes are swept away.

.partial-1234abcd/lock     held by `flock` as long as the maker lives; says on which machine, and what is made
.partial-1234abcd/new/OUT  the result that is being made
.partial-1234abcd/old/OUT  what stood in its place, only where a file system cannot exchange two names
"""

import fcntl
import os
import platform
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

NAME = re.compile(r"\.partial-[0-9a-f]{8}")
MEMBERS = {"lock", "new", "old"}
_held: set[Path] = set()  # places of this process


@dataclass(frozen=True)
class Staging:
    """A place where one result is made."""

    # the folder in which it lies: the nearest one around the result that exists, so that a result in folders which do
    # not exist yet appears with them in one step
    home: Path
    folder: Path  # the place itself
    name: Path  # the result as it is named from `home`

    @property
    def made(self) -> Path:
        """Where the result is made."""
        return self.folder / "new" / self.name

    @property
    def aside(self) -> Path:
        """Where the older result waits, if the two cannot be exchanged."""
        return self.folder / "old" / self.name


@contextmanager
def staging(path: Path) -> Iterator[Staging]:
    """A place for the result `path` (absolute, without links); places of dead processes beside it are swept first.

    Raises:
        OSError: none can be made there: no permission, a full or read-only file system, a file among the parents.
    """
    home = next(folder for folder in path.parents if folder.exists())
    sweep(home)
    place, lock = _make(home, path.relative_to(home))
    try:
        place.made.parent.mkdir(parents=True)
        yield place
    finally:
        _remove(place.folder)
        os.close(lock)


def remove_held() -> None:
    """Remove every place that this process still has: for a program that was stopped, wherever that was.

    Python can raise KeyboardInterrupt between any two steps, also between the end of a block and its tidying.
    """
    for folder in tuple(_held):
        _remove(folder)


def sweep(home: Path) -> None:
    """Remove what processes that are dead left in a folder; an older result that one of them moved aside returns."""
    for folder in _places(home):
        with suppress(OSError):  # a living one, or one of somebody else
            _clear_if_dead(folder)


def made_by_another(place: Staging) -> Path | None:
    """The place in which another process makes the same result, if there is one."""
    for folder in _places(place.home):
        with suppress(OSError):
            text = (folder / "lock").read_text(encoding="utf-8", errors="surrogateescape")
            if folder != place.folder and text.split("\n", 2)[2:] == [os.fspath(place.name)]:
                return folder
    return None


def is_staged(path: Path) -> bool:
    """True for a path inside such a place."""
    return any(NAME.fullmatch(part) for part in path.parts)


def _places(home: Path) -> list[Path]:
    with suppress(OSError), os.scandir(home) as entries:
        return [Path(e.path) for e in entries if NAME.fullmatch(e.name) and e.is_dir(follow_symlinks=False)]
    return []


def _make(home: Path, name: Path) -> tuple[Staging, int]:
    """A new place, and its lock, which holds as long as it is open."""
    while True:
        folder = home / f".partial-{os.urandom(4).hex()}"
        lock = -1
        try:
            _held.add(folder)
            folder.mkdir(0o700)
            lock = os.open(folder / "lock", os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
            if _hold(lock):
                os.write(lock, "\n".join([*_machine(), os.fspath(name)]).encode("utf-8", "surrogateescape"))
                return Staging(home, folder, name), lock
        except FileExistsError:
            _held.discard(folder)  # the name is taken
            continue
        except FileNotFoundError as error:
            _held.discard(folder)
            # of the place itself: no folder is made in some file systems, such as /proc, that have this one
            if not home.exists() or error.filename == os.fspath(folder):
                raise
        except BaseException:
            _remove(folder)
            if lock >= 0:
                os.close(lock)
            raise
        # a sweeping process was faster: it took the place, which nobody held yet, for a dead one
        _held.discard(folder)
        if lock >= 0:
            os.close(lock)


def _hold(lock: int) -> bool:
    """False when another process holds the lock, or has removed it. Without locks in the file system it counts as held.

    There nobody else can hold it either, and so nobody sweeps.
    """
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return os.fstat(lock).st_nlink > 0


def _machine() -> list[str]:
    """What tells this machine from others: its name, and its start."""
    try:
        start = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        start = ""
    return [platform.node(), start]


def _clear_if_dead(folder: Path) -> None:
    """Remove a place that nobody holds. OSError: somebody does, or it cannot be told."""
    names = {entry.name for entry in folder.iterdir()}
    if not names:
        folder.rmdir()
        return
    if "lock" not in names or not names <= MEMBERS or folder.lstat().st_uid != os.getuid():
        return  # not ours
    lock = os.open(folder / "lock", os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        text = os.read(lock, 4096).decode("utf-8", "replace").splitlines()
        # a lock of another machine is seen on most network file systems, but not on all
        if not text or any(a == b != "" for a, b in zip(text, _machine(), strict=False)):
            _clear(folder)
    finally:
        os.close(lock)


def _remove(folder: Path) -> None:
    with suppress(OSError):  # what cannot be removed now is swept by the next run
        _clear(folder)
    _held.discard(folder)


def _clear(folder: Path) -> None:
    """Remove a place. The lock goes last: what is left after a stop in the middle is still known for what it is."""
    old = folder / "old"
    for entry in old.iterdir() if old.is_dir() else ():
        if not os.path.lexists(folder.parent / entry.name):
            entry.rename(folder.parent / entry.name)  # the maker died between its two steps
    for part in ("new", "old"):
        if os.path.lexists(folder / part):
            shutil.rmtree(folder / part)
    (folder / "lock").unlink(missing_ok=True)
    folder.rmdir()
