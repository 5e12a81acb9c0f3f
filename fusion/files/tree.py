"""A folder, or a zip archive of one, read in the same way: names, then the bytes behind a name."""

import os
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from fusion.errors import FusionError
from fusion.files.inside import inside
from fusion.files.limits import check_size
from fusion.files.reading import beginning, open_regular, read_bytes

ZIP = (b"PK\x03\x04", b"PK\x05\x06")
LISTED = 20  # bytes in memory for each of an archive's list, of which an entry takes 46 and its name
LOCAL = struct.Struct("<4s5H3I2H")  # what stands before a member
END = struct.Struct("<4s4H2IH")  # what stands at the end of an archive
LAST = END.size + 65535  # a comment may follow
COPIES = "__MACOSX/"  # what a Mac puts beside the files when it packs them


@dataclass(frozen=True)
class Tree:
    """A folder on disk, or in a zip archive."""

    path: Path  # the folder or the archive
    root: str = ""  # where the content begins in the archive, "" or "name/"
    # of an archive, by their name below the root; None for a folder
    members: Mapping[str, zipfile.ZipInfo] | None = field(default=None, repr=False)
    error: type[FusionError] = FusionError  # the kind of error to raise

    def has(self, name: str) -> bool:
        """True where there is a file of this name, such as "depth/0.png"."""
        return (self.path / name).is_file() if self.members is None else name in self.members

    def names(self, folder: str) -> list[str]:
        """Names of the files in one folder of the tree, without it, sorted; none where there is no such folder."""
        if self.members is not None:
            begin = f"{folder}/" if folder else ""
            found = {name[len(begin) :] for name in self.members if name.startswith(begin)}
            return sorted(name for name in found if name and "/" not in name)
        try:
            with os.scandir(inside(self.path, folder, self.error)) as entries:
                return sorted(entry.name for entry in entries if entry.is_file())
        except OSError:
            return []

    def where(self, name: str) -> Path:
        """How a file is named in messages."""
        return self.path / name

    def read(self, name: str, what: str = "the file") -> bytes:
        """All bytes of a file; its size is looked at before.

        Raises:
            FusionError: of the kind `error`: no such file, not regular, too large, damaged, packed in an unusual way.
        """
        if self.members is None:
            return read_bytes(inside(self.path, name, self.error), self.error, what)
        info = self.members.get(name)
        if info is None:
            raise self.error(f"{what} is not in the archive", self.where(name), "nothing", "a file of that name")
        check_size(max(info.file_size, info.compress_size), f"{self.path}/{name}", self.error, what)
        with open_regular(self.path, self.error, "the archive", takes=0) as file:
            file.seek(max(0, info.header_offset))
            head = file.read(LOCAL.size)
            if len(head) < LOCAL.size or head[:4] != ZIP[0]:
                raise self._damaged(name, what, "no file where the archive's list says")
            *_, name_size, extra_size = LOCAL.unpack(head)
            file.seek(name_size + extra_size, os.SEEK_CUR)
            data = file.read(info.compress_size)
        return self._unpacked(data, info, name, what)

    def _unpacked(self, data: bytes, info: zipfile.ZipInfo, name: str, what: str) -> bytes:
        if info.flag_bits & 1:
            raise self.error(f"{what} is encrypted", self.where(name), do="unpack the archive with its password")
        if info.compress_type == zipfile.ZIP_DEFLATED:
            try:
                data = zlib.decompressobj(-15).decompress(data, info.file_size + 1)
            except zlib.error as problem:
                raise self._damaged(name, what, problem) from problem
        elif info.compress_type != zipfile.ZIP_STORED:
            raise self.error(
                f"{what} is packed in a way that is not read", self.where(name), info.compress_type, "deflate, or none"
            )
        if len(data) != info.file_size or zlib.crc32(data) != info.CRC:
            raise self._damaged(name, what, "other bytes than were packed")
        return data

    def _damaged(self, name: str, what: str, found: object) -> FusionError:
        return self.error(f"{what} is damaged in the archive", self.where(name), found, "a whole archive")


def is_zip(path: Path) -> bool:
    """True for a file that begins as a zip archive does."""
    return beginning(path, 4) in ZIP


def open_tree(path: Path, error: type[FusionError], marker: str) -> Tree:
    """The tree of a folder or of a zip archive.

    Args:
        marker: a file or the beginning of a name that the content has; a folder that was packed with its own name is
            found by it.

    Raises:
        FusionError: of the kind `error`: the archive is cut off or damaged, or its list takes too much memory.
    """
    if path.is_dir():
        return Tree(path, error=error)
    members = _members(path, error)
    roots = {name[: at + 1] if at >= 0 else "" for name in members for at in [_before(name, marker)] if at >= -1}
    root = min(roots, key=len, default="")
    kept = {name[len(root) :]: info for name, info in members.items() if name.startswith(root)}
    return Tree(path, root, kept, error)


def _before(name: str, marker: str) -> int:
    """Where the root ends in a name, -1 for none; -2 where the name has not the marker."""
    if name.startswith(marker):
        return -1
    at = name.find("/" + marker)
    return at if at >= 0 else -2


def _members(path: Path, error: type[FusionError]) -> Mapping[str, zipfile.ZipInfo]:
    with open_regular(path, error, "the archive", takes=0) as file:
        there = os.fstat(file.fileno())
    version = (there.st_dev, there.st_ino, there.st_size, there.st_mtime_ns)
    return _listed(path.absolute(), version, error)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=1)
def _listed(path: Path, version: tuple[int, int, int, int], error: type[FusionError]) -> Mapping[str, zipfile.ZipInfo]:
    """What is in an archive. Each format that may be one asks, then the one that is reads it: the list of 60 000 files
    takes half a second, and is kept as long as the file is the same."""
    with open_regular(path, error, "the archive", takes=0) as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - LAST))
        tail = file.read()
        at = tail.rfind(ZIP[1])
        if at < 0 or len(tail) < at + END.size:
            raise error("the archive is cut off", path, "no list of its files", "a whole zip archive", "copy it again")
        *_, listed, _, _ = END.unpack_from(tail, at)
        # 4 GB and more: the list's size stands elsewhere; it is no longer than what is before its end
        check_size(LISTED * (listed if listed < 0xFFFFFFFF else _far(file, tail, at)), path, error, "an archive's list")
        try:
            with zipfile.ZipFile(file) as archive:
                infos = archive.infolist()
        except Exception as problem:  # whatever it makes of damaged bytes
            raise error("the archive cannot be read", path, str(problem)[:80], "a whole zip archive") from problem
    return {info.filename: info for info in infos if not info.is_dir() and not info.filename.startswith(COPIES)}


def _far(file: object, tail: bytes, at: int) -> int:
    """Bytes of the list of an archive of 4 GB and more; 0 where its end cannot be found: the reader then refuses it."""
    place = at - 20
    if place < 0 or tail[place : place + 4] != b"PK\x06\x07":
        return 0
    (offset,) = struct.unpack_from("<Q", tail, place + 8)
    try:
        file.seek(offset)  # type: ignore[attr-defined]
        head = file.read(56)  # type: ignore[attr-defined]
    except (OSError, OverflowError, ValueError):
        return 0
    return struct.unpack_from("<Q", head, 40)[0] if len(head) == 56 and head[:4] == b"PK\x06\x06" else 0
