"""fusion's volume."""

import numpy as np
from common import load, measure_volume

from fusion.compute.process import tune_process
from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings

tune_process()
w = load()
K = w.K
camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
metres = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in w.depth]


class Ours:
    def __init__(self) -> None:
        self.volume = Volume(VolumeSettings(w.voxel, w.truncation))

    def integrate(self, k: int) -> None:
        self.volume.integrate(metres[k], camera, w.poses[k])

    def raycast(self, k: int) -> np.ndarray:
        return self.volume.raycast(camera, w.poses[k], far=w.far).depth

    def extract(self) -> tuple[np.ndarray, int]:
        mesh = self.volume.surface()
        return mesh.vertices, len(mesh.faces)


measure_volume(Ours, w)
