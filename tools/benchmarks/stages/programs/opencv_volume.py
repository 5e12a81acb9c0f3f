# mypy: ignore-errors
"""OpenCV 5's Volume, hashed (HashTSDF), the first 20 frames; it gives points instead of a mesh."""

import cv2
import numpy as np
from common import load, measure_volume

w = load()
cv2.ocl.setUseOpenCL(False)
depths = [d.astype(np.float32) for d in w.depth[:20]]
poses = [T.astype(np.float32) for T in w.poses]


class Cv:
    def __init__(self) -> None:
        kind = cv2.VolumeType_HashTSDF
        s = cv2.VolumeSettings(kind)
        s.setIntegrateWidth(640)
        s.setIntegrateHeight(480)
        s.setRaycastWidth(640)
        s.setRaycastHeight(480)
        s.setCameraIntegrateIntrinsics(w.K.astype(np.float32))
        s.setCameraRaycastIntrinsics(w.K.astype(np.float32))
        s.setDepthFactor(1000.0)
        s.setMaxDepth(w.far)
        s.setVoxelSize(w.voxel)
        s.setTsdfTruncateDistance(w.truncation)
        s.setMaxWeight(100)
        s.setVolumePose(np.eye(4, dtype=np.float32))
        self.volume = cv2.Volume(kind, s)

    def integrate(self, k: int) -> None:
        self.volume.integrate(depths[k], poses[k])

    def raycast(self, k: int) -> np.ndarray:
        return self.volume.raycast(poses[k])[0][..., 2]

    def extract(self) -> tuple[np.ndarray, int]:
        return self.volume.fetchPointsNormals()[0][:, :3], 0


measure_volume(Cv, w, frames=20)
