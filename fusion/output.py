"""Results appear whole or not at all: written beside their final place, then moved there. Nothing else is replaced."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fusion import __version__
from fusion.errors import FusionError

MARK = ".fusion.json"  # beside a command's result: which command made which files


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` with the same ending; moved to `path` when the block ends well."""
    path = Path(path)
    _make_folder(path.parent)
    handle, name = tempfile.mkstemp(prefix=".partial-", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    partial = Path(name)
    try:
        yield partial
        partial.chmod(0o666 & ~_umask())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def output_folder(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path`; its files replace those of the same name in `path` when the block ends well.

    Other files that stand in `path` already are left alone.
    """
    path = Path(path)
    if path.exists() and not path.is_dir():
        raise FusionError("the output is not a folder", path, "a file", "a folder or a new name", "choose another -o")
    _make_folder(path.parent)
    partial = Path(tempfile.mkdtemp(prefix=f".partial-{path.name}-", dir=path.parent))
    try:
        yield partial
        _make_folder(path)
        for source in sorted(partial.iterdir()):
            target = path / source.name
            if target.is_dir() and not target.is_symlink():
                shutil.rmtree(target)
            source.replace(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@contextmanager
def claimed(path: Path, command: str, inputs: Iterable[Path] = (), overwrite: bool = False) -> Iterator[None]:
    """The block makes `path`, a folder or a file, as a command's result; what must not be replaced is refused first.

    When the block ends well, a folder is marked as the command's, and what an earlier result of the same command left
    there is removed where it was not made anew. Files of others stay.

    Raises:
        FusionError: `path` is an input, lies in one or holds one; or it exists and may not be replaced.
    """
    path = Path(path)
    for given in inputs:
        _refuse_input(path, Path(given))
    earlier = _replaceable(path, command, overwrite)
    before = _entries(path)
    yield
    if path.is_dir():
        now = _entries(path)
        for name in earlier & {name for name, entry in now.items() if before.get(name) == entry}:
            _remove(path / name)
            del now[name]
        made = sorted(name for name, entry in now.items() if before.get(name) != entry)
        content = {"command": command, "fusion": __version__, "files": made}
        with atomic_file(path / MARK) as partial:
            partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _refuse_input(path: Path, given: Path) -> None:
    out, read = path.resolve(), given.resolve()
    if out == read or read in out.parents or out in read.parents:
        where = "is" if out == read else "lies in" if read in out.parents else "holds"
        raise FusionError(f"the output {where} the input", path, given, "a place of its own", "choose another output")


def _replaceable(path: Path, command: str, overwrite: bool) -> set[str]:
    """Names of what an earlier result of the command put into `path`; FusionError where something must stay."""
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        return set()
    if path.is_file():
        if not overwrite:
            do = "pass --overwrite to replace it, or choose another name"
            raise FusionError("the output exists already", path, "a file", "a new name", do)
        return set()
    try:
        mark = json.loads((path / MARK).read_text(encoding="utf-8"))
        maker, files = str(mark["command"]), {str(name) for name in mark["files"]}
    except (OSError, ValueError, TypeError, KeyError):
        maker, files = "", set()
    if maker != command:
        found = f"a result of fusion {maker}" if maker else "files that fusion did not mark as a result of its own"
        expected = f"a new or empty folder, or an earlier result of fusion {command}"
        raise FusionError("the output is not empty", path, found, expected, "choose another output")
    if not overwrite:
        found, do = f"an earlier result of fusion {command}", "pass --overwrite to replace it, or choose another output"
        raise FusionError("the output exists already", path, found, "a new or empty folder", do)
    return {name for name in files if name == Path(name).name}


def _entries(path: Path) -> dict[str, tuple[int, int]]:
    """What stands in a folder, each with what changes when it is made anew."""
    if not path.is_dir():
        return {}
    found = {entry.name: entry.lstat() for entry in path.iterdir() if entry.name != MARK}
    return {name: (state.st_ino, state.st_mtime_ns) for name, state in found.items()}


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FusionError("the output folder cannot be made", path, error.strerror, do="choose another -o") from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
