"""Gives each frame its pose."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from fusion.errors import VolumeError
from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array
from fusion.reconstruction.loops.edges import agree, landmark_edge, tracked_edge
from fusion.reconstruction.loops.keyframes import SIGHTED, Keyframes, keyframe_of
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.recording import Recording
from fusion.tracking.tracker import Tracked, Tracker
from fusion.volume.blocks import FullError
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume

MODEL_WIDTH = 400  # the model is seen at half resolution from images wider than this: noise is finer than it [px]
SURE = 0.9  # of the usual share must fit, where nothing but the surface tells that a place is the same (guess)
LOOKED = 20  # key frames at most that a lost frame is compared with
PATIENCE = 5  # frames lost in a row, after which the camera is taken to be where it never was (guess)


@dataclass
class Placer:
    """Gives each frame its pose: the stated one, or a tracked one.

    Where tracking has lost the camera and does not find it again, a new piece begins, with a model of its own: where it
    lies to those before is found out later, by what both saw.
    """

    recording: Recording
    settings: ReconstructSettings
    volume: Volume  # the model of the present piece
    piece: int = 0  # its number
    keyframes: Keyframes = field(default_factory=Keyframes)  # of all pieces
    shares: list[float] = field(default_factory=list)  # of the points of the frames so far that fitted
    tracker: Tracker = field(init=False)

    def __post_init__(self) -> None:
        given, camera = self.settings.poses, self.recording.camera
        self.poses = None if given is None else given.at(self.recording.timestamps).poses
        self.model_camera = camera.halved() if camera.width > MODEL_WIDTH else camera
        self.far = self.settings.max_depth or 20.0
        self.tracker = Tracker(self._model, self.settings.tracker)

    def __call__(self, index: int, frame: Prepared) -> Tracked:
        tracked = self._placed(index, frame)
        if tracked.ok:
            self.shares += [tracked.inlier_share] if np.isfinite(tracked.inlier_share) else []
            try:
                fuse(self.volume, frame, tracked.T_world_camera)
            except FullError as error:
                found = f"{error.found} after {index + 1} of {len(self.recording)} frames"
                do = "take a larger --voxel, or --room where it is one, or pass --memory GB"
                raise FullError(error.what, self.recording.path, found, error.expected, do) from error
            if self.poses is None and not self.volume.block_count:
                return self._unfused()
        return tracked

    def _unfused(self) -> Tracked:
        """A frame before any model, as of noise alone: the next one is the first."""
        if self.settings.box is not None or self.settings.max_depth is not None:
            raise VolumeError("nothing of the first frame was fused", do="check --box and --max-depth")
        self.tracker = Tracker(self._model, self.settings.tracker)
        return self.skip("nothing of it was fused")

    def look(self, frame: Prepared, tracked: Tracked) -> bool:
        """Keep a tracked frame as a key frame, where it is time for one; says whether."""
        if not tracked.ok:
            self.keyframes.lost()
        free = tracked.ok and self.poses is None
        return free and self.keyframes.look(self.piece, tracked.T_world_camera, frame, bool(tracked.unconstrained))

    def skip(self, reason: str) -> Tracked:
        return self.tracker.skip(reason)

    def _placed(self, index: int, frame: Prepared) -> Tracked:
        if self.poses is None:
            tracked = self.tracker.place(
                frame.surface, lambda found: self._sure(frame, found), places=lambda: self._recognised(frame)
            )
            # in a box only what is in it is fused, and where the box is in a new piece is not known
            lost = not tracked.ok and self.tracker.past and self.tracker.lost > PATIENCE and self.settings.box is None
            return self._begun(frame, tracked) if lost else tracked
        T = self.poses[index]
        return Tracked(T) if np.isfinite(T).all() else self.skip("no pose is given for its time stamp")

    def _sure(self, frame: Prepared, found: Tracked) -> bool:
        """A frame found again after a loss shows what the key frames around show: walls alone fit in many places."""
        here = keyframe_of(frame, self.piece, found.T_world_camera)
        near = [other for other in self.keyframes.around(here) if other.landmarks is not None]
        if here.landmarks is None or len(here.landmarks) < SIGHTED or not near:
            return found.inlier_share > SURE * float(np.median(self.shares or [1.0]))
        for other in near:
            seen = landmark_edge([other, here], 0, 1, doubtful=True)
            if seen is not None and agree(seen, tracked_edge([other, here], 0, 1)):
                return True
        return False

    def _recognised(self, frame: Prepared) -> Iterator[Array]:
        """`T_world_camera` (4, 4) of a lost frame by the landmarks that it shares with key frames, the newest first."""
        here = keyframe_of(frame, self.piece, np.eye(4))
        if here.landmarks is None or len(here.landmarks) < SIGHTED:
            return
        own = [other for other in reversed(self.keyframes.found) if other.piece == self.piece]
        for other in own[:: max(-(-len(own) // LOOKED), 1)]:
            seen = landmark_edge([other, here], 0, 1, doubtful=True)
            if seen is not None:
                yield other.T_world_camera @ seen.T_i_j

    def _begun(self, frame: Prepared, lost: Tracked) -> Tracked:
        """The frame as the first of a new piece, where it shows a surface."""
        tracker = Tracker(self._model, self.settings.tracker, start=self.tracker.past[-1][1])
        first = tracker.place(frame.surface)
        if not first.ok:
            return lost
        self.tracker, self.volume, self.piece = tracker, Volume(self.volume.settings), self.piece + 1
        return first

    def _model(self, T_world_camera: Array) -> PointMap:
        seen = self.volume.raycast(self.model_camera, T_world_camera, far=self.far)
        # the noise of the model is small against that of a frame: many frames made it
        return PointMap(self.model_camera, seen.points, seen.normals, np.zeros_like(seen.depth))
