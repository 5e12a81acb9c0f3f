"""What the system refuses while a result is written, told as what it is: a matter of the output, not of the input."""

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fusion.errors import FusionError
from fusion.files.output.staging import is_staged

FULL = {errno.ENOSPC: "the disk is full", errno.EDQUOT: "your share of the disk is used up"}
DO = "choose another output"


@contextmanager
def told(path: Path) -> Iterator[None]:
    """Errors of the block that come from writing `path` become a FusionError that says so."""
    try:
        yield
    except Exception as error:
        # what is made inside a result is told by who makes the whole: only there the name is what the user typed
        problem = None if is_staged(Path(path)) else _problem(error, Path(path))
        if problem is None:
            raise
        raise problem from error


def of_the_disk(said: str) -> bool:
    """Whether a command said that the disk was full: with more room it may work."""
    return any(full in said for full in FULL.values())


def _problem(error: BaseException | None, path: Path) -> FusionError | None:
    """Also where a reader took the error for one of its own: the cause tells."""
    while error is not None:
        if isinstance(error, OSError):
            if full := FULL.get(error.errno or 0):
                found = f"{shutil.disk_usage(_standing(path)).free / 1e6:.1f} MB free in {_mount(path)}"
                return FusionError(full, path, found, do=f"free some space, or {DO}")
            if any(is_staged(Path(os.fsdecode(name))) for name in (error.filename, error.filename2) if name):
                return FusionError("the output cannot be written", path, error.strerror, "a folder to write in", DO)
        error = error.__cause__ or error.__context__
    return None


def _mount(path: Path) -> Path:
    """Where the file system is mounted."""
    path = _standing(path).resolve()
    return next(folder for folder in (path, *path.parents) if folder.is_mount())


def _standing(path: Path) -> Path:
    return next(folder for folder in (path, *path.absolute().parents) if folder.is_dir())
