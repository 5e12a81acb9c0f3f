"""Prints the least wall time of integrate and raycast together [ms]; the cores come from the environment."""

import time

import numpy as np
from common import load

from fusion.compute.process import tune_process
from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings

tune_process()
w = load()
K = w.K
camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
volume = Volume(VolumeSettings(w.voxel, w.truncation))
metres = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in w.depth[:12]]
times = []
for k in range(40):
    start = time.perf_counter()
    volume.integrate(metres[k % 12], camera, w.poses[k % 12])
    volume.raycast(camera, w.poses[k % 12], far=w.far)
    times.append(time.perf_counter() - start)
print(min(times[5:]) * 1e3)
