"""Gives each frame its pose."""

import numpy as np

from fusion.errors import VolumeError
from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.recording import Recording
from fusion.tracking.tracker import Tracked, Tracker
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Volume

MODEL_WIDTH = 400  # the model is seen at half resolution from images wider than this: noise is finer than it [px]


class Placer:
    """Gives each frame its pose: the stated one, or a tracked one."""

    def __init__(self, recording: Recording, settings: ReconstructSettings, volume: Volume) -> None:
        self.poses = None if settings.poses is None else settings.poses.at(recording.timestamps).poses
        camera = recording.camera
        self.model_camera = camera.halved() if camera.width > MODEL_WIDTH else camera
        self.far = settings.max_depth or 20.0
        self.volume = volume
        self.tracker = Tracker(self._model, settings.tracker)

    def __call__(self, index: int, frame: Prepared) -> Tracked:
        if self.poses is None:
            if self.tracker.past and not self.volume.block_count:
                raise VolumeError("nothing of the first frame was fused", do="check --box and --max-depth")
            return self.tracker.place(frame.surface)
        T = self.poses[index]
        return Tracked(T) if np.isfinite(T).all() else self.skip("no pose is given for its time stamp")

    def skip(self, reason: str) -> Tracked:
        return self.tracker.skip(reason)

    def _model(self, T_world_camera: Array) -> PointMap:
        seen = self.volume.raycast(self.model_camera, T_world_camera, far=self.far)
        # the noise of the model is small against that of a frame: many frames made it
        return PointMap(self.model_camera, seen.points, seen.normals, np.zeros_like(seen.depth))
