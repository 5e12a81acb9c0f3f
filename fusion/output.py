"""Results appear whole or not at all: written beside their final place, then moved there."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fusion.errors import FusionError


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


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FusionError("the output folder cannot be made", path, error.strerror, do="choose another -o") from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
