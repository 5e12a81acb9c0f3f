"""Parts of a recording in which the target stands still: split where log, poses or images say that it was moved."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.looking.moved import unmoved_parts
from fusion.recording.recording import Recording

LEAST = 10  # frames: fewer say little about a noise, and are what a moved target leaves
BLOCK = 8  # [px] images are compared by medians over such squares
MOVED, MOVED_SHARE = 0.03, 0.02  # share of the depth; share of the blocks that change by more when a target is moved


def still_parts(recording: Recording) -> list[range]:
    """Frame numbers of each part; one that is shorter than 10 frames is dropped, unless the recording itself is."""
    parts = [part for unmoved in unmoved_parts(recording) for part in _seen(recording, unmoved.start, unmoved.stop)]
    least = min(LEAST, len(recording))
    return [part for part in parts if len(part) >= least]


def _seen(recording: Recording, first: int, last: int) -> list[range]:
    """Parts of the frames [first, last) whose images agree; looks are half as far apart as a part is long at least."""
    every = LEAST // 2
    looks = [*range(first, last, every)]
    if looks[-1] != last - 1:
        looks.append(last - 1)
    parts: list[range] = []
    begin = first
    anchor = _blocks(recording, looks[0])
    for before, look in pairwise(looks):
        image = _blocks(recording, look)
        if image is None or anchor is None or not _differ(anchor, image):
            anchor = image if anchor is None else anchor
            continue
        end = next(i for i in range(before + 1, look + 1) if i == look or _other(recording, anchor, i))
        parts.append(range(begin, end))
        begin, anchor = look if _other(recording, image, end) else end, image
    return [*parts, range(begin, last)]


def _other(recording: Recording, anchor: NDArray[np.floating], index: int) -> bool:
    image = _blocks(recording, index)
    return image is not None and _differ(anchor, image)


def _blocks(recording: Recording, index: int) -> NDArray[np.floating] | None:
    """Medians of a frame's squares; None for a frame that cannot be read."""
    try:
        depth = recording[index].depth
    except RecordingError:
        return None
    h, w = (size // BLOCK * BLOCK for size in depth.shape)
    squares = depth[:h, :w].reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK).swapaxes(1, 2).reshape(-1, BLOCK**2)
    # missing as infinity: the median of a square is a value when most of its pixels have one
    return np.asarray(np.median(np.where(np.isfinite(squares), squares, np.inf), axis=1))


def _differ(one: NDArray[np.floating], other: NDArray[np.floating]) -> bool:
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 4:
        return False
    return bool((np.abs(one[both] - other[both]) > MOVED * one[both]).sum() > max(MOVED_SHARE * both.sum(), 3))
