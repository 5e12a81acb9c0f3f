"""Where compiled kernels are kept from one process to the next."""

import errno
import os
import stat
import sys
import tempfile
from pathlib import Path

from fusion.compute.back_end import KEPT
from fusion.progress import note

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def kept_in() -> Path | None:
    """The folder of compiled kernels, which is there; None where they can be kept nowhere.

    It is what a variable of the back end's own says, or one below XDG_CACHE_HOME or ~/.cache; where that cannot be made
    (a container that can only be read, a user without a home) one of this user's own among the temporary files. The
    back end takes the whole process down where it cannot make its folder.
    """
    variable, name = KEPT
    cache = os.environ.get("XDG_CACHE_HOME")
    try:
        own = os.environ.get(variable)
        folder = Path(own) if own else (Path(cache) if cache else Path.home() / ".cache") / "fusion" / name
        made = not folder.exists()  # one that is there and can only be read is read
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError) as error:  # RuntimeError: no home
        return _passing(name, f"{error}; XDG_CACHE_HOME names another place")
    if made:
        note("compiling the kernels, once on this machine: up to a minute")
    return folder


def _passing(name: str, why: str) -> Path | None:
    """A folder among the temporary files that is this user's alone, as what lies in it is run."""
    try:
        folder = Path(tempfile.gettempdir()) / f"fusion-{name}"
        if sys.platform != "win32":  # there each user has an own place for temporary files
            folder = folder.with_name(f"{folder.name}-{os.getuid()}")
        made = not folder.exists()
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if sys.platform != "win32" and (found.st_uid != os.getuid() or found.st_mode & OTHERS):
            raise PermissionError(errno.EPERM, "not this user's alone", str(folder))
    except OSError:
        note(f"compiling the kernels, up to a minute each time: {why}")
        return None
    if made:
        note(f"compiling the kernels, kept in {folder}: {why}")
    return folder
