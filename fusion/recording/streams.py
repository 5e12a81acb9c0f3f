"""The images behind a recording's frames where they are no files of their own: what `FrameFiles` is to a folder."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FrameStreams:
    """Which images there are in a recorded file, and how those are read that no frame holds.

    Attributes:
        color, ir: (n,) bool, frames that have such an image; empty when no frame has one.
        counts: depth counts (h, w) uint16 of a frame, 0 and 65535 missing; None where depth is stored in metres.
        color_apart: the colour image (h, w, 3) uint8 RGB of a frame in the pixels of `camera.color`, which is not where
            the depth camera is, or None; raises RecordingError. None where colour is in the frames themselves.
        steps_back: how many stamps were earlier than the one before.
        arrivals: (n,) [s] when each frame was recorded, by the recording machine's clock; empty where nothing says it.
        unmatched: stream: (images without a depth frame in time, images in the stream).
    """

    color: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    ir: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    counts: Callable[[int], NDArray[np.uint16]] | None = None
    color_apart: Callable[[int], NDArray[np.uint8] | None] | None = None
    steps_back: int = 0
    arrivals: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    unmatched: dict[str, tuple[int, int]] = field(default_factory=dict)
