"""Packed parts of bags: unpacked to the size that they claim, which is looked at before."""

import bz2
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from fusion.errors import RecordingError
from fusion.files.extra import extra
from fusion.files.limits import check_size
from fusion.recording.formats.bags.containers.store import cut

KEPT = 3  # unpacked chunks of a file: depth, colour and what comes next lie side by side
ZSTD = b"\x28\xb5\x2f\xfd"


@dataclass(frozen=True)
class Chunk:
    """Where a chunk's records lie in the file, how they are packed, and their size unpacked."""

    at: int
    packed: int
    how: str
    size: int


def unpack(data: bytes, how: str, size: int, path: Path) -> bytes:
    """Packed bytes as `size` bytes; `how`: "", "none", "bz2", "lz4" or "zstd". Raises RecordingError."""
    check_size(size, path, RecordingError, "a chunk of the bag")
    if how in ("", "none"):
        made = data
    elif how == "bz2":
        made = _by_steps(bz2.BZ2Decompressor(), data, size, path)
    elif how == "lz4":
        made = _lz4(data, size, path)
    elif how == "zstd":
        made = _zstd(data, size, path)
    else:
        raise RecordingError("the bag is packed in a way that is not known", path, repr(how[:20]), "bz2, lz4 or zstd")
    if len(made) != size:
        raise cut(path, f"a chunk of {len(made)} bytes that claims {size}")
    return made


def unpack_message(data: bytes, path: Path) -> bytes:
    """A message packed alone, as recorders may do; of zstd's own claim of size. Raises RecordingError."""
    library = extra("zstandard", "bags", "a packed message", path, RecordingError)
    try:
        size = library.frame_content_size(data)
    except library.ZstdError as problem:
        raise cut(path, "a message that cannot be unpacked") from problem
    if size < 0:
        raise RecordingError("a packed message does not tell its size", path, do="ros2 bag convert unpacks it")
    return unpack(data, "zstd", size, path)


class Chunks:
    """The last few unpacked chunks of a file, for all threads."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._kept: dict[int, bytes] = {}

    def get(self, at: int) -> bytes | None:
        """The chunk that begins at this byte of the file, if it is here still."""
        with self._lock:
            return self._kept.get(at)

    def put(self, at: int, data: bytes) -> None:
        """Keep a chunk, and let the oldest go."""
        with self._lock:
            self._kept[at] = data
            while len(self._kept) > KEPT:
                self._kept.pop(next(iter(self._kept)))


def _by_steps(tool: "bz2.BZ2Decompressor", data: bytes, size: int, path: Path) -> bytes:
    try:
        return tool.decompress(data, max_length=size)
    except (OSError, EOFError, ValueError) as problem:
        raise cut(path, "a chunk that cannot be unpacked (bz2)") from problem


def _lz4(data: bytes, size: int, path: Path) -> bytes:
    library = extra("lz4.frame", "bags", "a bag packed by LZ4", path, RecordingError)
    try:
        return bytes(library.LZ4FrameDecompressor().decompress(data, max_length=size))
    except (RuntimeError, EOFError, ValueError) as problem:
        raise cut(path, "a chunk that cannot be unpacked (lz4)") from problem


def _zstd(data: bytes, size: int, path: Path) -> bytes:
    library = extra("zstandard", "bags", "a bag packed by Zstandard", path, RecordingError)
    try:
        with library.ZstdDecompressor().stream_reader(data, read_across_frames=True) as stream:
            made: bytes = stream.read(size) if size else b""
    except library.ZstdError as problem:
        raise cut(path, "a chunk that cannot be unpacked (zstd)") from problem
    return made
