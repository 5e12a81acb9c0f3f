"""A few frames of a recording, loaded once for all checks."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.ahead import ahead
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.recording.recording import Frame, Recording

# statistics over thirty frames say what those over all would; geometry needs fewer, and memory
FRAMES, KEPT = 30, 10
# a metre too many: coarser images say the same about planes and poses
KEPT_PIXELS = 320 * 240


@dataclass(frozen=True)
class Sample:
    """Numbers of some frames, and the depth of fewer, evenly spread over the recording."""

    recording: Recording  # what it is a sample of
    # (65536,) how often each count occurs in the sampled frames, all 0 where depth is not stored in counts
    counts: NDArray[np.int64]
    medians: NDArray[np.float64]  # (n,) median depth [m] of each frame, NaN where a frame has none
    depths: dict[int, NDArray[np.float32]]  # depth images [m] of the kept frames by index, every `stride`-th pixel
    colors: dict[int, NDArray[np.uint8]]  # colour images (h, w, 3) of those frames, on the grid of `depths`
    stride: int  # [px]
    failures: dict[int, str]  # frame index: why it could not be loaded

    @property
    def unread(self) -> list[str]:
        """A sentence for each frame that could not be loaded."""
        return [f"frame {index} cannot be loaded: {reason}" for index, reason in self.failures.items()]

    @property
    def rays(self) -> NDArray[np.float32]:
        """(h, w, 2) x/z and y/z of the pixels of `depths`."""
        return self.recording.camera.rays()[:: self.stride, :: self.stride]


def draw(recording: Recording, frames: int = FRAMES, keep: int = KEPT) -> Sample:
    """Load up to `frames` frames and keep the depth of `keep`; those that cannot be loaded are told in `failures`."""
    indices = spread(len(recording), frames)
    kept = {indices[i] for i in spread(len(indices), keep)}
    camera = recording.camera
    stride = max(1, int(np.ceil(np.sqrt(camera.width * camera.height / KEPT_PIXELS))))
    counts = np.zeros(INVALID_COUNT + 1, np.int64)
    medians, depths, colors, failures = [], {}, {}, {}

    def read(index: int) -> tuple[Frame, NDArray[np.uint16] | None]:
        return recording[index], recording.depth_counts(index)

    for index, seen in zip(indices, ahead(read, indices), strict=True):
        try:
            frame, stored = seen()
            if stored is not None:
                counts += np.bincount(stored.reshape(-1), minlength=INVALID_COUNT + 1)
        except RecordingError as error:
            failures[index] = str(error)
            continue
        valid = frame.depth[np.isfinite(frame.depth)]
        medians.append(float(np.median(valid)) if valid.size else np.nan)
        if index in kept:
            depths[index] = frame.depth[::stride, ::stride].copy()
            if frame.color is not None:
                grid = depths[index].shape[::-1]
                colors[index] = np.asarray(cv2.resize(frame.color, grid, interpolation=cv2.INTER_AREA), np.uint8)
    return Sample(recording, counts, np.array(medians), depths, colors, stride, failures)


def spread(count: int, most: int) -> list[int]:
    """Up to `most` indices evenly spread over `count`, first and last among them."""
    return sorted({int(i) for i in np.linspace(0, count - 1, min(count, most)).round()}) if count else []
