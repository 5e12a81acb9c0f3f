"""A recording: a camera and frames that are loaded when they are asked for."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.frame_files import FrameFiles


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
    """

    index: int
    timestamp: float
    depth: NDArray[np.float32]
    color: NDArray[np.uint8] | None = None
    ir: NDArray[np.uint16] | None = None
    unfit: tuple[str, ...] = ()

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

    def __repr__(self) -> str:
        files = self.files or FrameFiles(self.path, ())
        held = [name for name, names in (("color", files.color or files.color_apart), ("ir", files.ir)) if any(names)]
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

    def telemetry_at_frames(self, column: str) -> NDArray[np.float64] | None:
        """A telemetry column at the frames' time stamps (n,), linear in time; None when it was not logged."""
        if column not in self.telemetry:
            return None
        stamps, values = self.telemetry["timestamp"], self.telemetry[column]
        known = np.isfinite(stamps) & np.isfinite(values)
        if not known.any():
            return None
        return np.interp(self.timestamps, stamps[known], values[known])
