# mypy: ignore-errors
"""VDBFusion: one thread, no carving, no raycast; making points from depth is not counted."""

import numpy as np
import vdbfusion
from common import load, measure_volume

w = load()
v, u = np.mgrid[0:480, 0:640]
x, y = (u - w.K[0, 2]) / w.K[0, 0], (v - w.K[1, 2]) / w.K[1, 1]


def points(k: int) -> np.ndarray:
    z = w.depth[k] * 1e-3
    local = np.stack([x * z, y * z, z], axis=-1)[z > 0]
    return np.ascontiguousarray(local @ w.poses[k, :3, :3].T + w.poses[k, :3, 3])


clouds = [points(k) for k in range(len(w.depth))]


class Vdb:
    def __init__(self) -> None:
        self.volume = vdbfusion.VDBVolume(w.voxel, w.truncation, space_carving=False)

    def integrate(self, k: int) -> None:
        self.volume.integrate(clouds[k], w.poses[k])

    def extract(self) -> tuple[np.ndarray, int]:
        vertices, triangles = self.volume.extract_triangle_mesh(True, 1.0)
        return np.asarray(vertices), len(triangles)


measure_volume(Vdb, w, raycasts=False)
