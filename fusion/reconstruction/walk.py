"""One walk through a recording: every frame placed and fused, key frames kept; and the fusion at known poses."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.progress import each
from fusion.reconstruction.loops.between import Between
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.reconstruction.placing import Placer
from fusion.reconstruction.planning import Plan, room_after_all
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.recording import Recording
from fusion.sensor.moments import Moments, moments_of
from fusion.sensor.sensor import Sensor
from fusion.tracking.tracker import Tracked
from fusion.volume.prepared import Prepared, fuse, fusing_weight, prepare
from fusion.volume.volume import Volume

KEPT = 400 << 20  # bytes of frames that are kept to be fused once more: 160 of 640 x 480 (guess)


@dataclass
class WalkedFrames:
    """The frames of a corrected recording, made ready one at a time.

    Attributes:
        kept: of those fused last, depth and weight for a truncation, as many as fit: they may be fused once more.
    """

    recording: Recording
    sensor: Sensor
    max_depth: float | None
    moments: Moments = field(init=False)
    kept: dict[int, tuple[NDArray[np.float32], NDArray[np.float32], float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.moments = moments_of(self.recording)

    def __getitem__(self, index: int) -> Prepared:
        """Raises RecordingError."""
        frame = self.recording[index]
        return prepare(frame, self.recording.camera, self.sensor, self.moments[index], self.max_depth)

    def keep(self, index: int, frame: Prepared, truncation: float) -> None:
        """Remember what is to be fused of a frame, while there is room for it."""
        if index in self.kept or 8 * frame.depth.size * (len(self.kept) + 1) <= KEPT:
            self.kept[index] = frame.depth, fusing_weight(frame, truncation), truncation

    def fuse(self, volume: Volume, index: int, T_world_camera: Array) -> None:
        """Fuse a frame at a pose (4, 4); raises RecordingError."""
        depth, weight, truncation = self.kept.get(index, (None, None, 0.0))
        if depth is None or truncation != volume.settings.truncation:
            fuse(volume, self[index], T_world_camera)
        else:
            volume.integrate(depth, self.recording.camera, T_world_camera, weight)


@dataclass(frozen=True)
class Walk:
    """What one walk gave."""

    results: list[Tracked]  # (n) of the frames
    pieces: NDArray[np.int64]  # (n,) of the trajectory that each belongs to
    keyframes: list[Keyframe]  # that stand for all
    volume: Volume  # of the last piece
    plan: Plan  # how it was fused


def track(frames: WalkedFrames, settings: ReconstructSettings, plan: Plan) -> Walk:
    """Place and fuse every frame."""
    recording = frames.recording
    placer = Placer(recording, settings, Volume(plan.volume))
    results: list[Tracked] = []
    pieces = np.zeros(len(recording), np.int64)
    for index in each(range(len(recording)), "tracking"):
        try:
            frame = frames[index]
        except RecordingError as error:  # one broken file is no reason to lose the others
            results.append(placer.skip(str(error)))
            continue
        results.append(placer(index, frame))
        if results[-1].ok and settings.poses is None:
            frames.keep(index, frame, placer.volume.settings.truncation)
        pieces[index] = placer.piece
        if not placer.look(frame, results[-1]) or plan.subject.room:
            continue
        grown = room_after_all(plan, recording, settings, placer.keyframes.shown(placer.piece))
        if grown is not None:
            plan = grown
            here = [i for i, r in enumerate(results) if r.ok and pieces[i] == placer.piece]
            placer.volume = fused(frames, results, plan, here)
    return Walk(results, pieces, placer.keyframes.found, placer.volume, plan)


def fused_again(
    frames: WalkedFrames, results: Sequence[Tracked], plan: Plan, between: Between
) -> tuple[Volume, list[Tracked]]:
    """All frames in a new volume, at the poses that the key frames beside them allow; lost ones may be found now."""
    volume, placed = Volume(plan.volume), list(results)
    for index in each(range(len(results)), "fusing again"):
        result = results[index]
        if not result.ok and not result.tried:
            continue
        if result.ok and between.sure(index):
            frames.fuse(volume, index, result.T_world_camera)
            continue
        frame = frames[index]
        T = between.place(frame, result.T_world_camera)
        if T is not None:
            # what was said of a lost frame was said of where it is not
            placed[index] = replace(result, T_world_camera=T) if result.ok else Tracked(T)
            fuse(volume, frame, T)
    return volume, placed


def fused(frames: WalkedFrames, results: Sequence[Tracked], plan: Plan, which: Sequence[int]) -> Volume:
    """Some placed frames in a new volume."""
    volume = Volume(plan.volume)
    for index in each(which, "fusing again"):
        frames.fuse(volume, index, results[index].T_world_camera)
    return volume
