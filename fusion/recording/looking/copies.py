"""A recording given twice is no evidence: its noise would be taken for something that comes again."""

from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.recording import Recording

Image = NDArray[np.floating]
Prints = frozenset[bytes]
SOME = 3  # frames that tell one recording from another
FEW = 100  # values whose noise might come twice by chance (guess)


def print_of(depth: Image) -> bytes:
    """What tells a depth frame [m] from every other; empty where it holds too few values to do so."""
    told = np.count_nonzero(np.isfinite(depth)) >= FEW
    return blake2b(np.ascontiguousarray(depth).data, digest_size=16).digest() if told else b""


def refuse_copies(recordings: Sequence[tuple[Path, Prints]]) -> None:
    """Two recordings of one place, or that share a frame, value for value, are one: noise never comes twice.

    Args:
        recordings: folder and prints of the frames of each.

    Raises:
        RecordingError: the first two that share one.
    """
    for place, (path, prints) in enumerate(recordings):
        for earlier, others in recordings[:place]:
            shared = len(prints & others)
            if shared or (path.exists() and path.resolve() == earlier.resolve()):
                raise RecordingError(
                    "a recording is given twice, and a copy is no second measurement",
                    path,
                    f"{shared} frames of {len(prints)} that are those of {earlier}" if shared else earlier,
                    "recordings of their own",
                    "leave it out, or record again",
                )


def refuse_repeated(recordings: Sequence[Recording]) -> None:
    """As `refuse_copies`, of recordings that are still to be read: by some frames of each. Raises RecordingError."""
    refuse_copies([(recording.path, _prints_of(recording)) for recording in recordings])


def _prints_of(recording: Recording) -> Prints:
    prints = set()
    for index in np.unique(np.linspace(0, len(recording) - 1, SOME).astype(int)):
        try:
            prints.add(print_of(recording[int(index)].depth))
        except RecordingError:  # whoever reads it tells
            continue
    return frozenset(prints - {b""})
