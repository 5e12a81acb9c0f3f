"""A recording: a camera and frames that are loaded when they are asked for."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.images.frame_files import FrameFiles


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


@dataclass(frozen=True)
class Frame:
    """One moment of a recording.

    Attributes:
        index: position in the recording, from 0.
        timestamp: [s].
        depth: (height, width) float32, planar z [m], NaN where missing.
        color: (height, width, 3) uint8 RGB in the depth camera's pixels, or None.
        ir: (height, width) uint16 counts, or None.
        unfit: "color" or "ir" where there is such an image in other pixels than the depth camera's.
        noisier: (height, width) float32, how many times the noise of a sure pixel the camera itself gives each one (its
            confidence), 1 or more; None where it says nothing.
    """

    index: int
    timestamp: float
    depth: NDArray[np.float32]
    color: NDArray[np.uint8] | None = None
    ir: NDArray[np.uint16] | None = None
    unfit: tuple[str, ...] = ()
    noisier: NDArray[np.float32] | None = None

    def __repr__(self) -> str:
        height, width = self.depth.shape
        held = ", ".join(["depth"] + [name for name in ("color", "ir") if getattr(self, name) is not None])
        return f"<Frame {self.index}: {width} x {height}, {held}, {self.timestamp:.3f} s>"


@dataclass(frozen=True)
class Recording:
    """Frames of one camera; `recording[i]` and iteration load from disk, nothing is kept.

    Attributes:
        path: the folder (or file) it was read from.
        format: "native", "tum", "7scenes", "bop", ... as recognised.
        camera: intrinsics of the depth frames.
        timestamps: (n,) [s].
        load: reads one frame by its index; raises RecordingError.
        poses: stated poses (`groundtruth.txt` and the like), or None.
        telemetry: columns of `telemetry.csv`, each (m,), with "timestamp"; empty when there is none.
        scene: content of `scene.json`; empty when there is none.
        warnings: what looked wrong while opening, one sentence each.
        files: the image files behind the frames, or None when the frames come from elsewhere.
        streams: what stands for `files` in a recording that is one file, or None.
        settings: what it says of the device and how that was set, words by name; empty when it says nothing.
    """

    path: Path
    format: str
    camera: Camera
    timestamps: NDArray[np.float64]
    load: Callable[[int], Frame]
    poses: Trajectory | None = None
    telemetry: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    scene: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    files: FrameFiles | None = None
    streams: FrameStreams | None = None
    settings: dict[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        held = [name for name, has in (("color", self.has_color), ("ir", self.has_ir)) if has is not None and has.any()]
        held += ["poses"] * (self.poses is not None) + ["scene"] * bool(self.scene)
        held += [name for name in self.telemetry if name != "timestamp"]
        seconds = np.ptp(self.timestamps) if len(self) else 0.0
        size = f"{len(self)} frames of {self.camera.width} x {self.camera.height} in {seconds:.1f} s"
        return f"<Recording {self.path.name}: {self.format}, {size}; {', '.join(['depth', *held])}>"

    def __len__(self) -> int:
        return len(self.timestamps)

    def __getitem__(self, index: int) -> Frame:
        if not 0 <= index < len(self):
            raise IndexError(index)
        return self.load(index)

    def __iter__(self) -> Iterator[Frame]:
        return (self.load(i) for i in range(len(self)))

    @property
    def in_counts(self) -> bool:
        """Depth is stored as whole counts, which the camera's depth_scale makes metres of."""
        return self.files is not None or (self.streams is not None and self.streams.counts is not None)

    @property
    def has_color(self) -> NDArray[np.bool_] | None:
        """(n,) True for each frame with a colour image, in whose pixels ever; None where that is not known."""
        if self.files is not None:
            return self._named(self.files.color_apart or self.files.color)
        return None if self.streams is None else self._flags(self.streams.color)

    @property
    def has_ir(self) -> NDArray[np.bool_] | None:
        """(n,) True for each frame with an infrared image; None where that is not known."""
        if self.files is not None:
            return self._named(self.files.ir)
        return None if self.streams is None else self._flags(self.streams.ir)

    @property
    def color_is_apart(self) -> bool:
        """Colour images are in the pixels of `camera.color`, and read by `color_apart` alone."""
        if self.files is not None:
            return any(self.files.color_apart)
        return self.streams is not None and self.streams.color_apart is not None

    def color_apart(self, index: int) -> NDArray[np.uint8] | None:
        """The colour image (h, w, 3) of a frame in the pixels of `camera.color`, or None. Raises RecordingError."""
        if self.files is not None:
            name = self.files.color_apart[index] if self.files.color_apart else None
            return None if name is None else self.files.read_color(name, (self.camera.color or self.camera).shape)
        return self.streams.color_apart(index) if self.streams and self.streams.color_apart else None

    def without_color(self) -> "Recording":
        """The same frames as if no colour had been recorded."""
        files = self.files and replace(self.files, color=(), color_apart=())
        streams = self.streams and replace(self.streams, color=np.zeros(0, bool), color_apart=None)
        return replace(self, load=lambda index: replace(self.load(index), color=None), files=files, streams=streams)

    def depth_counts(self, index: int) -> NDArray[np.uint16] | None:
        """Counts (h, w) of a frame's depth as they are stored, or None where there are none. Raises RecordingError."""
        if self.files is not None:
            return self.files.read_depth(self.files.folder / self.files.depth[index], self.camera.shape)
        return self.streams.counts(index) if self.streams and self.streams.counts else None

    def _named(self, names: Sequence[str | None]) -> NDArray[np.bool_]:
        return self._flags(np.array([name is not None for name in names], bool))

    def _flags(self, has: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return has if len(has) else np.zeros(len(self), bool)

    def telemetry_at_frames(self, column: str) -> NDArray[np.float64] | None:
        """A telemetry column at the frames' time stamps (n,), linear in time; None when it was not logged."""
        if column not in self.telemetry:
            return None
        stamps, values = self.telemetry["timestamp"], self.telemetry[column]
        known = np.isfinite(stamps) & np.isfinite(values)
        if not known.any():
            return None
        return np.interp(self.timestamps, stamps[known], values[known])
