"""A folder as it is: every name with its kind, rights and content, so that any change shows."""

import hashlib
import os
import stat
from pathlib import Path

Snapshot = dict[str, str]  # name relative to the folder: kind, rights, and a hash of the content or a link's target
LARGE = 50_000_000  # sparse giants are known by their size


def snapshot(folder: Path) -> Snapshot:
    """Look at everything below a folder, links not followed."""
    found: Snapshot = {}
    for where, folders, files in os.walk(folder):
        for name in [*folders, *files]:
            path = Path(where, name)
            found[os.fsdecode(os.path.relpath(path, folder))] = _described(path)
    return found


def _described(path: Path) -> str:
    there = path.lstat()
    rights = oct(stat.S_IMODE(there.st_mode))
    if stat.S_ISLNK(there.st_mode):
        return f"link {path.readlink()}"
    if stat.S_ISDIR(there.st_mode):
        return f"folder {rights}"
    if not stat.S_ISREG(there.st_mode):
        return f"special {stat.S_IFMT(there.st_mode):o} {rights}"
    if there.st_size > LARGE:
        return f"file {rights} {there.st_size} {there.st_mtime_ns}"
    try:
        content = hashlib.blake2b(path.read_bytes(), digest_size=12).hexdigest()
    except OSError as error:
        content = error.strerror or "unreadable"
    return f"file {rights} {there.st_size} {content}"


def within(name: str, folder: str) -> bool:
    """Whether a name of a snapshot is a folder or lies in it."""
    return name == folder or name.startswith(folder + "/")


def changes(before: Snapshot, after: Snapshot, apart: tuple[str, ...]) -> list[str]:
    """What became new, was lost or changed, apart from some names and what lies below them."""
    told = []
    for name in sorted(before.keys() | after.keys()):
        if any(within(name, one) for one in apart):
            continue
        if name not in after:
            told.append(f"lost {name!r}")
        elif name not in before:
            told.append(f"new {name!r}")
        elif before[name] != after[name]:
            told.append(f"changed {name!r}")
    return told
