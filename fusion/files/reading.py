"""The one place where a file from outside is opened."""

import codecs
import os
import stat
from pathlib import Path
from typing import BinaryIO

from fusion.errors import FusionError
from fusion.files.limits import check_size

KINDS = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}
TEXT_TAKES = 10  # bytes in memory for each of a text that is taken apart into words and numbers
MARKS = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}  # what begins a text that is not UTF-8


def open_regular(
    path: Path | str, error: type[FusionError] = FusionError, what: str = "the file", takes: int = 1
) -> BinaryIO:
    """A regular file of a size that is allowed, opened for reading; a pipe or a device is refused without a wait.

    Args:
        takes: bytes in memory for each of the file.

    Raises:
        FusionError: of the kind `error`: no such file, no permission, not a regular file, too large.
    """
    try:
        # without O_NONBLOCK a pipe that nobody writes to would be waited for
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as problem:  # ValueError: a null byte in the name
        found = getattr(problem, "strerror", None) or problem
        raise error(f"{what} cannot be read", path, found, "a file", "check the path") from problem
    try:
        state = os.fstat(handle)
        if not stat.S_ISREG(state.st_mode):
            found = KINDS.get(stat.S_IFMT(state.st_mode), "something else")
            raise error(f"{what} is not a regular file", path, found, "a file")
        check_size(takes * state.st_size, path, error, what)
    except BaseException:
        os.close(handle)
        raise
    return os.fdopen(handle, "rb")


def read_bytes(
    path: Path | str, error: type[FusionError] = FusionError, what: str = "the file", most: int = -1, takes: int = 1
) -> bytes:
    """The first `most` bytes of a regular file (-1: all). Arguments and errors as of `open_regular`."""
    with open_regular(path, error, what, takes) as file:
        try:
            return file.read(most)
        except OSError as problem:
            raise error(f"{what} cannot be read", path, problem.strerror or problem) from problem


def beginning(path: Path | str, most: int = 64) -> bytes:
    """The first bytes of a regular file of any size; nothing where there is none: for looking at what a file is."""
    try:
        with open_regular(path, takes=0) as file:
            return file.read(most)
    except (FusionError, OSError):
        return b""


def read_text(path: Path | str, error: type[FusionError] = FusionError, what: str = "the file") -> str:
    """The text of a UTF-8 file, or of a UTF-16 one that begins with its mark; line ends become `\\n`.

    Raises:
        FusionError: of the kind `error`: as `open_regular`, or the file is not text.
    """
    data = read_bytes(path, error, what, takes=TEXT_TAKES)
    try:
        return decoded(data)
    except ValueError as problem:
        raise error(f"{what} is not text", path, problem, "UTF-8 text") from problem


def decoded(data: bytes) -> str:
    """Bytes as text: UTF-8, with or without a mark, or UTF-16 with one; line ends become `\\n`.

    Raises:
        ValueError: says which byte is none of a text.
    """
    encoding = MARKS.get(data[:2], "utf-8-sig")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as problem:
        raise ValueError(f"byte {data[problem.start]} at {problem.start}") from problem
    if "\0" in text:
        raise ValueError(f"a null byte at {text.index(chr(0))}")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def unmarked(data: bytes) -> bytes:
    """The same bytes, or those of the UTF-8 text behind a mark: for files that begin with text and may be binary."""
    if data[:2] in MARKS or data.startswith(codecs.BOM_UTF8):
        return decoded(data).encode()
    return data
