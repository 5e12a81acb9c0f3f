"""How many frames saw each vertex of a mesh."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.drawing.shading import vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import ahead

GRAZING = 0.17  # cosine of 80 degrees: beyond, depth cameras give no usable depth (guess)
NEARER = 0.99  # a surface hides a vertex when it stands nearer than this share of the way to it


def times_seen(mesh: Mesh, trajectory: Trajectory, camera: Camera) -> NDArray[np.int32]:
    """Number of frames (n,) that had each vertex in the picture, turned to them and not hidden by the mesh itself."""
    import open3d as o3d

    counts = np.zeros(len(mesh.vertices), np.int32)
    if len(mesh.vertices) == 0 or len(mesh.faces) == 0:
        return counts
    middle = np.nanmean(mesh.vertices, axis=0)
    scene = o3d.t.geometry.RaycastingScene()
    local = np.nan_to_num(mesh.vertices - middle).astype(np.float32)
    scene.add_triangles(o3d.core.Tensor.from_numpy(local), o3d.core.Tensor.from_numpy(mesh.faces.astype(np.uint32)))
    # coordinates one after the other: three values side by side cost NumPy several times as much
    points, normals = (np.ascontiguousarray(values.T, float) for values in (mesh.vertices, vertex_normals(mesh)))

    def seen(frame: int) -> NDArray[np.int64]:
        T_world_camera = trajectory.poses[frame]
        index = _in_view(points, normals, T_world_camera, camera)
        eye = T_world_camera[:3, 3] - middle
        rays = np.hstack([np.broadcast_to(eye, (len(index), 3)), local[index] - eye]).astype(np.float32)
        if not len(index):
            return index
        return index[~scene.test_occlusions(o3d.core.Tensor.from_numpy(rays), tnear=0.0, tfar=NEARER).numpy()]

    for found in ahead(seen, np.flatnonzero(trajectory.valid).tolist()):
        counts[found()] += 1
    return counts


def _in_view(points: NDArray, normals: NDArray, T_world_camera: NDArray, camera: Camera) -> NDArray[np.int64]:
    """Vertices (k,), of points (3, n) with normals, in front of the camera, turned to it, and inside its picture."""
    away = points - T_world_camera[:3, 3, None]
    turned = -np.sum(away * normals, axis=0) > GRAZING * np.sqrt(np.sum(away**2, axis=0))
    seen = T_world_camera[:3, :3].T @ away[:, turned]
    index, seen = np.flatnonzero(turned)[seen[2] > 1e-3], seen[:, seen[2] > 1e-3]
    u, v = camera.project(seen.T).T
    return index[(u > -0.5) & (u < camera.width - 0.5) & (v > -0.5) & (v < camera.height - 0.5)]
