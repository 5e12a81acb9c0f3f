"""A command's claim on its output, made before any work: nothing is replaced but an earlier result of its own."""

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from fusion import __version__
from fusion.errors import FusionError
from fusion.files.output.publish import carry_over, place_of, put
from fusion.files.output.refused import told
from fusion.files.output.staging import Staging, made_by_another, staging, sweep
from fusion.files.reading import read_text

MARK = ".fusion.json"  # in a command's result: which command made which files


@dataclass
class OutputClaim:
    """An output that one run may make."""

    path: Path  # as the user named it
    place: Path  # where that is
    command: str  # who makes it, such as "calibrate depth"
    overwrite: bool  # an earlier result of the same command may be replaced
    at: Staging  # where it is made
    _made: tuple[int, int] | None = field(default=None, init=False)

    @contextmanager
    def folder(self, grows: tuple[str, ...] = ()) -> Iterator[Path]:
        """Where the content of the result is to be made; when the block ends well it is put in its place, marked.

        What an earlier result of the command left there goes; what others put there stays. Files and folders that
        `grows` names belong to the result too, also those in them that come later.
        """
        with told(self.path):
            made = self.at.made
            made.mkdir()
            yield made
            mark = {"command": self.command, "fusion": __version__, "files": [*_files(made), *grows]}
            earlier = self._earlier()
            carry_over(self.place, made, lambda name: name == MARK or _within(name, earlier))
            (made / MARK).write_text(json.dumps(mark, indent=1) + "\n", encoding="utf-8")
            self._put()

    @contextmanager
    def file(self) -> Iterator[Path]:
        """The same for a result that is one file, without a mark."""
        with told(self.path):
            yield self.at.made
            self._earlier()
            self._put()

    @property
    def kept(self) -> bool:
        """True when the result stands in its place, whatever stopped the run."""
        try:
            return self._made is not None and self._made == _identity(self.place)
        except OSError:
            return False

    @property
    def outcome(self) -> str:
        """What a run that was stopped has left, as a clause."""
        return f"the result was complete and is in {self.path}" if self.kept else "nothing was written"

    def _earlier(self) -> set[str]:
        return replaceable(self.path, self.place, self.command, self.overwrite)

    def _put(self) -> None:
        self._made = _identity(self.at.made)
        put(self.at, self.place)


@contextmanager
def claimed(
    path: Path, command: str, inputs: Iterable[Path] = (), overwrite: bool = False, folder: bool = True
) -> Iterator[OutputClaim]:
    """The block may make `path` as the result of a command; what must not be replaced or written is refused first.

    Args:
        inputs: files and folders that are read; the output may not be one, lie in one or hold one.
        overwrite: an earlier result of the same command, or a file, is replaced.
        folder: the result is a folder, else a file.

    Raises:
        FusionError: `path` may not be replaced, or not be written.
    """
    path, place = Path(path), place_of(path)
    refuse_other_kind(path, place, folder)
    for given in inputs:
        refuse_input(path, place, Path(given))
    with ExitStack() as stack:
        with told(path):
            sweep(place.parent)
            replaceable(path, place, command, overwrite)
            _refuse_fixed(path, place)
            at = stack.enter_context(staging(place))
        if other := made_by_another(at):
            do = f"wait for it; if there is none any more, remove {other}"
            raise FusionError("the output is being made", path, "another run of fusion", do=do)
        yield OutputClaim(path, place, command, overwrite, at)


def refuse_other_kind(path: Path, place: Path, folder: bool) -> None:
    """FusionError where a file stands for a folder, or the other way round."""
    if folder and place.exists() and not place.is_dir():
        found, do = "a file" if place.is_file() else "something that is no folder", "choose another name"
        raise FusionError("the output is not a folder", path, found, "a folder or a new name", do)
    if not folder and place.exists() and not place.is_file():
        found, do = "a folder" if place.is_dir() else "something that is no file", "choose another name"
        raise FusionError("the output is not a file", path, found, "a file or a new name", do)


def refuse_input(path: Path, place: Path, given: Path) -> None:
    """FusionError where an output is, lies in or holds what is read."""
    read = given.resolve()
    if place == read or read in place.parents or place in read.parents:
        where = "is" if place == read else "lies in" if read in place.parents else "holds"
        raise FusionError(f"the output {where} the input", path, given, "a place of its own", "choose another output")


def replaceable(path: Path, place: Path, command: str, overwrite: bool) -> set[str]:
    """What an earlier result of the command put into `place`; FusionError where something must stay."""
    if not place.exists():
        return set()
    if place.is_dir():
        return _replaceable_folder(path, place, command, overwrite)
    maker, files = _mark(place.parent)
    if place.name in files:
        raise FusionError("the output exists already", path, f"a part of a result of fusion {maker}", "a new name")
    if not overwrite:
        do = "pass --overwrite to replace it, or choose another name"
        raise FusionError("the output exists already", path, "a file", "a new name", do)
    return set()


def _replaceable_folder(path: Path, place: Path, command: str, overwrite: bool) -> set[str]:
    sweep(place)
    if not any(place.iterdir()):
        return set()
    maker, files = _mark(place)
    if maker != command:
        found = f"a result of fusion {maker}" if maker else "files that fusion did not mark as a result of its own"
        expected = f"a new or empty folder, or an earlier result of fusion {command}"
        raise FusionError("the output is not empty", path, found, expected, "choose another output")
    if not overwrite:
        found, do = f"an earlier result of fusion {command}", "pass --overwrite to replace it, or choose another output"
        raise FusionError("the output exists already", path, found, "a new or empty folder", do)
    return files


def _refuse_fixed(path: Path, place: Path) -> None:
    """A folder whose place cannot be taken by another one."""
    do = f"choose a folder inside it, such as {path / 'result'}"
    if place.is_mount():
        found = "the root of a file system, which stays where it is"
        raise FusionError("the output cannot be replaced by a result", path, found, "a folder in it", do)
    here = Path.cwd()
    if place == here or place in here.parents:
        found = "the folder you stand in: it would be gone"
        raise FusionError("the output cannot be replaced by a result", path, found, "another folder", do)


def _mark(folder: Path) -> tuple[str, set[str]]:
    """Which command made which files of a folder; nothing where no mark says it."""
    try:
        mark = json.loads(read_text(folder / MARK))
        return str(mark["command"]), {str(name) for name in mark["files"]}
    except (FusionError, OSError, ValueError, TypeError, KeyError, RecursionError):
        return "", set()


def _within(name: str, earlier: set[str]) -> bool:
    """True for a file of an earlier result. Marks of fusion 0.1 name folders, not what is in them."""
    parts = name.split("/")
    return any("/".join(parts[: count + 1]) in earlier for count in range(len(parts)))


def _files(folder: Path) -> list[str]:
    """All files in a folder, each with `/` between the parts of its name."""
    found = [Path(inner, name) for inner, _, names in os.walk(folder) for name in names]
    return sorted(path.relative_to(folder).as_posix() for path in found)


def _identity(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_dev, state.st_ino
