"""Results appear whole or not at all: they are made beside their place (`staging`), then put there by one rename."""

import ctypes
import errno
import logging
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fusion.errors import FusionError
from fusion.files.output.refused import told
from fusion.files.output.staging import Staging, is_staged, staging

_HERE, _EXCHANGE = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of <linux/fs.h>


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Where the file `path` is to be made, under its own name elsewhere; it is put there when the block ends well.

    Raises:
        FusionError: it cannot be written there.
    """
    with told(path):
        place = place_of(path)
        if place.is_dir():
            raise FusionError("the output is a folder", path, "a folder", "a file's name", "choose another name")
        if is_staged(place):  # a part of something that is made: that appears whole or not at all
            place.parent.mkdir(parents=True, exist_ok=True)
            yield place
            return
        with staging(place) as at:
            yield at.made
            put(at, place)


@contextmanager
def output_folder(path: Path, replaces: Iterable[str] = ()) -> Iterator[Path]:
    """Where the content of the folder `path` is to be made; it is put there in one step when the block ends well.

    What stands in `path` already stays, besides what is made anew and what `replaces` names.

    Raises:
        FusionError: it cannot be written there.
    """
    with told(path):
        place = place_of(path)
        if place.exists() and not place.is_dir():
            raise FusionError("the output is not a folder", path, "a file", "a folder or a new name", "choose another")
        with staging(place) as at:
            at.made.mkdir()
            yield at.made
            gone = {*replaces, *(made.name for made in at.made.iterdir())}
            carry_over(place, at.made, lambda name: name.split("/")[0] in gone)
            put(at, place)


def place_of(path: Path) -> Path:
    """Where a result really goes: absolute, without links. Raises FusionError where there is no such place."""
    try:
        place = Path(path).resolve()
        place.exists()  # tells names that are too long
        if place.is_symlink():  # Python 3.13 says no more of a loop
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    except (OSError, ValueError, RuntimeError) as error:  # a null byte; a loop of links
        reason = getattr(error, "strerror", None) or str(error)
        raise FusionError("the output's name cannot be used", str(path)[:200], reason, "a new name") from error
    return place


def carry_over(old: Path, new: Path, gone: Callable[[str], bool], inner: str = "") -> None:
    """Let stand in the new folder too what others put into the old one: hard links, so that neither loses it.

    Args:
        old, new: the folders; an `old` that does not exist holds nothing.
        gone: True for a name in `old`, with `/` between its parts, that does not stay.
        inner: a folder in both, ending in `/`.
    """
    if not old.is_dir():
        return
    with os.scandir(old / inner) as entries:
        kept = [entry for entry in entries if not gone(inner + entry.name)]
    for entry in kept:
        source, target = Path(entry.path), new / inner / entry.name
        if not entry.is_dir(follow_symlinks=False):
            _link(source, target)
        elif any(source.iterdir()):
            carry_over(old, new, gone, f"{inner}{entry.name}/")
        else:
            target.mkdir(parents=True, exist_ok=True)


def _link(source: Path, target: Path) -> None:
    """One more name for a file; a copy where the file system knows no second names."""
    target.parent.mkdir(parents=True, exist_ok=True)
    free, count = target, 0
    while os.path.lexists(free):
        count += 1
        free = target.with_name(f"{target.stem}.kept{count}{target.suffix}")
    if count:
        # a warning and no note of progress: of a short run a log shows none
        logging.getLogger("fusion").warning("%s was not made by fusion: kept as %s", source, free.name)
    try:
        os.link(source, free, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, free, follow_symlinks=False)


def put(at: Staging, place: Path) -> None:
    """Put what was made in its place by one rename; what stood there is then where it was made."""
    parts = at.name.parts
    for count in range(1, len(parts)):  # folders around it that do not exist yet come with it
        outer = at.home.joinpath(*parts[:count])
        try:
            if not outer.exists():
                (at.folder / "new").joinpath(*parts[:count]).rename(outer)
                return
        except OSError as error:
            if error.errno not in (errno.EEXIST, errno.ENOTEMPTY):  # made by another process a moment ago
                raise
    if not (place.is_dir() and any(place.iterdir())):
        at.made.replace(place)
        return
    shutil.copymode(place, at.made)
    if not _exchange(at.made, place):
        at.aside.parent.mkdir(parents=True, exist_ok=True)
        place.rename(at.aside)  # a stop between these two: `staging` puts it back, at the latest in the next run
        at.made.rename(place)


def _exchange(one: Path, other: Path) -> bool:
    """Swap two names in one step; False where the system or the file system has no such step."""
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None) if sys.platform == "linux" else None
    if rename is None:
        return False
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
        return False
    raise OSError(number, os.strerror(number), str(one), None, str(other))
