"""How far normals of a raycast are from the knot's own: median and 95th percentile of the angle.

python -m tools.benchmarks.normals [--cache out/benchmark/cache]
"""

import argparse
from pathlib import Path

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.volume.volume import Volume, VolumeSettings
from tools.benchmarks.stages.knot import Knot
from tools.benchmarks.stages.workloads import made

CASES = [(noise, voxel, views) for noise, voxel in ((0.0, 2e-3), (2e-3, 2e-3), (2e-3, 4e-3)) for views in (1, 30)]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cache", type=Path, default=Path("out/benchmark/cache"), help="workloads of benchmark.py")
    with np.load(made("object", parser.parse_args().cache)) as data:
        depth, poses, K = data["depth"] * 1e-3, data["poses"], data["K"]
    camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    vertices, faces = Knot().mesh()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(vertices.astype(np.float32)), o3d.core.Tensor.from_numpy(faces.astype(np.uint32))
    )
    for noise, voxel, views in CASES:
        rng, volume = np.random.default_rng(0), Volume(VolumeSettings(voxel, 4 * voxel))
        for k in range(0, len(poses), 4)[:views]:
            seen = np.where(depth[k] > 0, depth[k] + rng.normal(0, noise, depth[k].shape), np.nan)
            volume.integrate(seen, camera, poses[k])
        angles = np.concatenate([_angles(volume, camera, T, scene) for T in poses[: 1 + 80 * (views > 1) : 40]])
        print(f"noise {1e3 * noise:g} mm, voxel {1e3 * voxel:g} mm, {views} views: median {np.median(angles):.2f}, "
              f"95th percentile {np.percentile(angles, 95):.1f} deg")  # fmt: skip


def _angles(volume: Volume, camera: Camera, T: Array, scene: o3d.t.geometry.RaycastingScene) -> NDArray[np.float64]:
    """Between the normals of a raycast and those of the mesh that the same rays meet within two voxels [deg]."""
    seen = volume.raycast(camera, T)
    there = np.isfinite(seen.normals[..., 0])
    rays = seen.points[there] @ T[:3, :3].T
    length = np.linalg.norm(rays, axis=1)
    cast = np.hstack([np.broadcast_to(T[:3, 3], rays.shape), rays / length[:, None]]).astype(np.float32)
    met = scene.cast_rays(o3d.core.Tensor.from_numpy(cast))
    same = np.abs(met["t_hit"].numpy() - length) < 2 * volume.settings.voxel
    cosine = np.abs(np.sum((seen.normals[there] @ T[:3, :3].T) * met["primitive_normals"].numpy(), axis=1))[same]
    return np.degrees(np.arccos(np.clip(cosine, 0, 1)))


if __name__ == "__main__":
    main()
