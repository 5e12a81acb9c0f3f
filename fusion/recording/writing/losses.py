"""What a recording loses on its way into a format: watched while its frames are written, told when they are."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Principle
from fusion.progress import each
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.recording.recording import Frame, Recording

# of a count: depth that is counts over their scale, as 32-bit numbers, is off by less than half of this
ROUNDING = 0.02
INFRARED, APART, TELEMETRY, SCENE = "infrared", "colour of another camera", "telemetry", "the scene"
SETTINGS, KIND = "how the camera was set", "the kind of camera"
BESIDE = (INFRARED, APART, TELEMETRY, SCENE, SETTINGS, KIND)


class Watched:
    """The frames of a recording, walked once; then `told` says what of them the format has no place for.

    Args:
        counts: whether depth becomes whole counts of its camera's unit.
        without: what of `BESIDE` the format has no place for.
    """

    def __init__(self, recording: Recording, counts: bool = True, without: Sequence[str] = ()) -> None:
        self.recording, self._counts, self._without = recording, counts, without
        self._left = Counter[str]()  # images by kind, pixels by where they are
        self._sure = 0
        self._off = 0.0

    def __iter__(self) -> Iterator[Frame]:
        for frame in each(self.recording, "converting"):
            self._left.update(frame.unfit)
            self._sure += frame.noisier is not None
            if self._counts:
                self._count(frame.depth)
            yield frame

    def _count(self, depth: NDArray[np.float32]) -> None:
        counts = depth[np.isfinite(depth)] * np.float32(self.recording.camera.depth_scale)
        whole = np.rint(counts)
        near, far = whole <= 0, whole >= INVALID_COUNT
        self._left["near"] += int(near.sum())
        self._left["far"] += int(far.sum())
        self._off = max(self._off, float(np.abs(counts - whole)[~(near | far)].max(initial=0.0)))

    def told(self) -> list[str]:
        """One sentence for each loss, of the frames so far."""
        count = 1000 / self.recording.camera.depth_scale
        images = Counter(self._left)
        near, far = images.pop("near", 0), images.pop("far", 0)
        told = []
        if self._off > ROUNDING:
            text = f"depth is rounded to whole counts of {count:g} mm, by up to {self._off * count:.2g} mm"
            told.append(f"{text}: it is stored otherwise (--format mcap keeps it as it is)")
        if far:
            told.append(f"{far} pixels from {count * INVALID_COUNT / 1000:.3g} m on have no count: left out")
        if near:
            told.append(f"{near} pixels nearer than {count / 2:.2g} mm have no count: left out")
        if self._sure:
            told.append(f"confidence of single pixels has no place in it: left out of {self._sure} frames")
        told += [f"{n} {name} images are not in the depth camera's pixels: left out" for name, n in images.items()]
        left = [name for name in self._beside() if name in self._without]
        return [*told, *([f"left out: {', '.join(left)}"] if left else [])]

    def _beside(self) -> list[str]:
        """What of `BESIDE` the recording has."""
        one = self.recording
        has = {
            INFRARED: one.has_ir is not None and bool(one.has_ir.any()),
            APART: one.color_is_apart,
            TELEMETRY: bool(one.telemetry),
            SCENE: bool(one.scene),
            SETTINGS: bool(one.settings),
            KIND: one.camera.principle != Principle.UNKNOWN or bool(one.camera.sensor),
        }
        return [name for name, there in has.items() if there]
