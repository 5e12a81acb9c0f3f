# mypy: ignore-errors
"""Open3D's tensor VoxelBlockGrid with blocks of 8."""

import numpy as np
import open3d as o3d
from common import load, measure_volume

w = load()
CPU, F32 = o3d.core.Device("CPU:0"), o3d.core.float32
K = o3d.core.Tensor(w.K)
images = [o3d.t.geometry.Image(o3d.core.Tensor(d)) for d in w.depth]
extrinsics = [o3d.core.Tensor(np.linalg.inv(T)) for T in w.poses]
band = w.truncation / w.voxel


class Grid:
    def __init__(self) -> None:
        self.grid = o3d.t.geometry.VoxelBlockGrid(("tsdf", "weight"), (F32, F32), ((1), (1)), w.voxel, 8, 20000, CPU)

    def _blocks(self, k: int):
        return self.grid.compute_unique_block_coordinates(
            images[k], K, extrinsics[k], 1000.0, w.far, trunc_voxel_multiplier=band
        )

    def integrate(self, k: int) -> None:
        self.grid.integrate(self._blocks(k), images[k], K, extrinsics[k], 1000.0, w.far, trunc_voxel_multiplier=band)

    def raycast(self, k: int) -> np.ndarray:
        seen = self.grid.ray_cast(
            self._blocks(k), K, extrinsics[k], 640, 480, ["depth", "vertex", "normal"], 1000.0, 0.1, w.far, 1.0,
            trunc_voxel_multiplier=band,
        )  # fmt: skip
        return seen["depth"].numpy()[..., 0] * 1e-3

    def extract(self) -> tuple[np.ndarray, int]:
        mesh = self.grid.extract_triangle_mesh(1.0)
        return mesh.vertex.positions.numpy(), len(mesh.triangle.indices)


measure_volume(Grid, w)
