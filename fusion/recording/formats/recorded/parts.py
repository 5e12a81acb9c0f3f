"""Parts of a recorded file: where the frames' data lie, read one by one."""

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular

FRAMES_PER_SECOND = 30.0  # where nothing tells it: what most depth cameras give


@dataclass(frozen=True)
class ByteRange:
    """Bytes of a file: from where, how many."""

    begin: int
    size: int


def read_part(path: Path, part: ByteRange, what: str) -> bytes:
    """The bytes of a part. Raises RecordingError where the file ends before."""
    check_size(part.size, path, RecordingError, what)
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        file.seek(part.begin)
        data = file.read(part.size)
    if len(data) < part.size:
        raise RecordingError(f"{what} is cut off", path, f"{len(data)} bytes", f"{part.size} bytes")
    return data


def unzipped(data: bytes, most: int, where: object, what: str) -> bytes:
    """What zlib packed, no more than `most` bytes of it. Raises RecordingError."""
    try:
        made = zlib.decompressobj().decompress(data, most + 1)
    except zlib.error as problem:
        raise RecordingError(f"{what} is damaged", where, problem, "bytes that zlib packed") from problem
    if len(made) > most:
        raise RecordingError(f"{what} is damaged", where, f"more than {most} bytes", f"{most} bytes")
    return made


def counts_of(data: bytes, shape: tuple[int, int], where: object) -> NDArray[np.uint16]:
    """(height, width) counts of as many little-endian numbers of 16 bits. Raises RecordingError."""
    if len(data) != 2 * shape[0] * shape[1]:
        expected = f"{2 * shape[0] * shape[1]} bytes, {shape[1]} x {shape[0]} pixels"
        raise RecordingError("a depth image is of another size", where, f"{len(data)} bytes", expected)
    return np.frombuffer(data, "<u2").reshape(shape).astype(np.uint16)


def even_or_stated(stamps: NDArray[np.float64], rate: float) -> tuple[NDArray[np.float64], list[str]]:
    """Stamps (n,) [s] as they are where they go on, else as many a second as is usual there; and what is told.

    A recording whose middle step is shorter than a millisecond or longer than a minute has another unit of time.

    Args:
        stamps: as they are stored.
        rate: where the steps forward tell none.
    """
    steps = np.diff(stamps)
    if len(stamps) < 2 or (np.isfinite(stamps).all() and (steps >= 0).all() and 1e-3 <= np.median(steps) <= 60):
        return stamps, []
    if np.isfinite(stamps).all() and (steps < 0).any():
        back, forward = int(steps.argmin()), steps[steps > 0]
        if len(forward) and 1e-3 <= np.median(forward) <= 60:
            rate = 1 / float(np.median(forward))
        why = f"go back {int((steps < 0).sum())} times (by {-steps[back]:.3g} s at frame {back + 1})"
    else:
        why = "are no seconds"
    told = f"the time stamps cannot be used, as they {why}: frames are taken for {rate:.4g} a second"
    return np.arange(len(stamps)) / rate, [told]


def no_stamps(count: int) -> tuple[NDArray[np.float64], list[str]]:
    """Stamps (count,) [s] of images that have none, and what is told of them."""
    told = f"the images have no time stamps: taken for {FRAMES_PER_SECOND:g} a second"
    return np.arange(count) / FRAMES_PER_SECOND, [told]
