"""fusion's whole update of a moving camera's frame: prepare, raycast, align, integrate, as `reconstruct` does it."""

import numpy as np
from common import Clock, answer, load

from fusion.compute.process import tune_process
from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.reconstruction.placing import MODEL_WIDTH
from fusion.recording.recording import Frame
from fusion.sensor.presets import default_sensor
from fusion.tracking.tracker import Tracker
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

FRAMES = 60
tune_process()
w = load()
K = w.K
camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
small = camera.halved() if camera.width > MODEL_WIDTH else camera
metres = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in w.depth]
frames = [Frame(k, k / 30, depth) for k, depth in enumerate(metres)]
sensor = default_sensor(camera)


def scan(count: int) -> tuple[list[float], list[np.ndarray], int]:
    """Times, poses and the number of lost frames."""
    volume = Volume(VolumeSettings(w.voxel, w.truncation))

    def model(T: np.ndarray) -> PointMap:
        seen = volume.raycast(small, T, far=w.far)
        return PointMap(small, seen.points, seen.normals, np.zeros_like(seen.depth))

    tracker, times, poses, lost = Tracker(model), [], [], 0  # type: ignore[var-annotated]
    for frame in frames[:count]:
        with Clock(times):
            ready = prepare(frame, camera, sensor)
            placed = tracker.place(ready.surface)
            if placed.ok:
                fuse(volume, ready, placed.T_world_camera)
        lost += not placed.ok
        poses.append(placed.T_world_camera)
    return times, poses, lost


scan(3)
times, poses, lost = scan(FRAMES)
drift = np.linalg.inv(np.linalg.inv(w.poses[0]) @ w.poses[FRAMES - 1]) @ poses[-1]
answer(times={"update": times[1:]}, lost=lost, drift_mm=float(np.linalg.norm(drift[:3, 3]) * 1e3))
