"""What may stand where a file should: nothing, another thing, a device, too much. And what may stand in a text."""

import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

Put = Callable[[Path], object]


def clear(path: Path) -> None:
    """Make room at a path."""
    if path.is_dir() and not path.is_symlink():
        import shutil

        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def link(target: str) -> Put:
    """A symbolic link in place of the file."""

    def put(path: Path) -> None:
        clear(path)
        path.symlink_to(target)

    return put


def fifo(path: Path) -> None:
    """A pipe that nobody writes into."""
    clear(path)
    os.mkfifo(path)


def folder(path: Path) -> None:
    """A folder where a file should be."""
    clear(path)
    path.mkdir()


def unix_socket(path: Path) -> None:
    """A socket where a file should be."""
    clear(path)
    here = Path.cwd()
    os.chdir(path.parent)  # the name of a socket may be 100 letters long
    try:
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(path.name)
    finally:
        os.chdir(here)


def sparse(size: int) -> Put:
    """The good content, then zeros up to a size that takes no room on the disk."""

    def put(path: Path) -> None:
        with path.open("ab") as file:
            file.truncate(size)

    return put


def missing(path: Path) -> None:
    """No file at all."""
    clear(path)


def empty(path: Path) -> None:
    """A file of no bytes."""
    path.write_bytes(b"")


def unreadable(path: Path) -> None:
    """A file without the right to read it."""
    path.touch()
    path.chmod(0)


# each of them is refused wherever one file is asked for
NO_FILE: dict[str, Put] = {
    "a FIFO": fifo, "a folder": folder, "a socket": unix_socket, "a link to /dev/zero": link("/dev/zero"),
    "a link to /dev/null": link("/dev/null"), "a link in a loop": lambda path: link(path.name)(path),
    "a link to nothing": link("nothing"), "no file": missing, "an empty file": empty,
    "a sparse file of 6 GB": sparse(6_000_000_000), "no right to read": unreadable,
}  # fmt: skip


def encodings(good: bytes) -> Iterator[tuple[str, bytes]]:
    """A text in other encodings and line ends."""
    text = good.decode("utf-8")
    yield "BOM", b"\xef\xbb\xbf" + good
    yield "CRLF", text.replace("\n", "\r\n").encode()
    yield "CR", text.replace("\n", "\r").encode()
    yield "UTF-16 with BOM", text.encode("utf-16")
    yield "UTF-16 without BOM", text.encode("utf-16-le")
    yield "NUL after each line", text.replace("\n", "\n\0").encode()
    yield "Latin-1", good.replace(b"\n", b" \xe9\n", 2)
    yield "surrogates", good + b"\xed\xa0\x80\n"


def cuts(good: bytes, times: int) -> Iterator[tuple[int, bytes]]:
    """The first bytes of a file, cut at evenly spread places."""
    for n in range(1, times + 1):
        at = len(good) * n // (times + 1)
        yield at, good[:at]
