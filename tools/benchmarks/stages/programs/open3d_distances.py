# mypy: ignore-errors
"""Open3D's ray-casting scene, unsigned."""

import numpy as np
import open3d as o3d
from common import Clock, answer, load

w = load()
build: list[float] = []
times: list[float] = []
points = o3d.core.Tensor(w.points.astype(np.float32))
for _ in range(2):
    with Clock(build):
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(o3d.core.Tensor(w.vertices.astype(np.float32)), o3d.core.Tensor(w.faces.astype(np.uint32)))
        scene.compute_distance(points[:1])
    with Clock(times):
        found = scene.compute_distance(points).numpy()
answer(times={"distances": times, "build": build}, mean_um=float(np.abs(found).mean() * 1e6), signed=False)
