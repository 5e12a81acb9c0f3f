"""Still stretches of a recording: frames in a row that see the same."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError, RecordingError
from fusion.recording.images.load_frame import load_depth
from fusion.recording.looking.moved import unmoved_parts
from fusion.recording.looking.sample import spread
from fusion.recording.recording import Recording

LOOKS = 32  # frames compared with each other
GRID = 4  # [px] between the pixels compared
CHANGE = 0.02  # share of the depth: more is a change of a pixel
CHANGED = 0.5  # share of the pixels: more is a camera that was moved; people and turntables leave more unchanged


@dataclass(frozen=True)
class Stretch:
    """Frames of a recording in which neither camera nor scene was moved."""

    recording: Recording  # it is part of
    frames: tuple[int, int]  # first and last + 1
    alone: bool  # it is the only one of its recording

    @property
    def name(self) -> str:
        """Of the recording, with the frames where there are several stretches."""
        name = self.recording.path.name or str(self.recording.path)
        return name if self.alone else f"{name} [{self.frames[0]}:{self.frames[1]}]"

    def __len__(self) -> int:
        return self.frames[1] - self.frames[0]

    def telemetry(self, column: str) -> float:
        """Mean of a telemetry column over the frames, NaN when it was not logged."""
        values = self.recording.telemetry_at_frames(column)
        return float("nan") if values is None else float(np.mean(values[slice(*self.frames)]))


def still_stretches(recording: Recording) -> list[Stretch]:
    """Split a recording where its log, its stated poses or its images change.

    A recording of one frame is one stretch; so is each frame that has a stated distance of its own.

    Raises:
        FusionError: no frame, or nothing stands still.
    """
    if not len(recording):
        raise RecordingError("the recording has no frames", recording.path, 0, "still frames, better 100")
    parts = [part for still in unmoved_parts(recording) for part in _without_change(recording, still.start, still.stop)]
    if not parts:
        raise FusionError(
            "nothing stands still in the recording",
            recording.path,
            f"{len(recording)} frames, each with another view",
            "frames of a camera that is not moved",
            "put the camera on a tripod and record 100 frames",
        )
    return [Stretch(recording, part, len(parts) == 1) for part in parts]


def _without_change(recording: Recording, first: int, last: int) -> list[tuple[int, int]]:
    """Parts of the frames [first, last) whose images agree with the first of the part; one look alone is dropped."""
    looks = [first + i for i in spread(last - first, LOOKS)]
    seen = {i: image for i in looks if (image := _coarse(recording, i)) is not None}
    looks = list(seen)
    if len(looks) <= 1 or last - first == 1:
        return [(first, last)]
    parts, begin, anchor, count = [], first, looks[0], 1
    for before, look in pairwise(looks):
        if not _differ(seen[anchor], seen[look]):
            count += 1
            continue
        end = _bisected(recording, seen[anchor], before, look)
        parts += [(begin, end)] if count > 1 else []
        begin, anchor, count = end, look, 1
    return [*parts, (begin, last)] if count > 1 else parts


def _bisected(recording: Recording, anchor: NDArray, same: int, other: int) -> int:
    """The first frame in (same, other] that no longer looks like the anchor."""
    while other - same > 1:
        middle = (same + other) // 2
        image = _coarse(recording, middle)
        if image is not None and _differ(anchor, image):
            other = middle
        else:
            same = middle
    return other


def _coarse(recording: Recording, index: int) -> NDArray[np.float32] | None:
    try:
        if recording.files is None:
            depth = recording[index].depth
        else:  # light is not looked at here, and takes twice as long to decode
            depth = load_depth(recording.files, recording.camera, index)
        return depth[::GRID, ::GRID].copy()
    except RecordingError:
        return None


def _differ(one: NDArray, other: NDArray) -> bool:
    """True when most of the pixels that both have changed."""
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 20:
        return False
    return bool((np.abs(one[both] - other[both]) > CHANGE * one[both]).mean() > CHANGED)
