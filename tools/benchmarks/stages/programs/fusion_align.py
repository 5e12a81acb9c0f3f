"""fusion's alignment of two depth images: the same work as OpenCV's odometry, which prepares both frames too, starts at
no motion and ends when it has settled. In a scan the model comes from the volume, and only one frame is prepared."""

import numpy as np
from common import load, measure_align

from fusion.compute.process import tune_process
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.tracking.icp import align

tune_process()
w = load()
K = w.K
camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
metres = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in w.depth]


def place(source: int, target: int) -> np.ndarray:
    return align(point_map(metres[source], camera), point_map(metres[target], camera), np.eye(4)).T_model_source


measure_align(place, w)
