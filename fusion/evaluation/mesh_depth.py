"""Depth of the mesh that `scene.json` states, as a camera without errors would see it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.stretches import Stretch
from fusion.errors import SceneError
from fusion.geometry.camera import Camera
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.native.scene_file import scene_mesh, stated_scene


def scene_depth(stretch: Stretch, camera: Camera) -> NDArray[np.floating] | None:
    """(h, w) depth [m] of the stated mesh from the stretch's pose, NaN beside it; None when none is stated.

    A pose that was tracked with the same depth holds its errors, so only surveyed ones count as truth.

    Raises:
        SceneError, MeshError: the mesh cannot be read.
    """
    recording = stretch.recording
    path, source = scene_mesh(recording), stated_scene(recording).stated_poses.source
    if path is None or source != "surveyed" or recording.poses is None or not len(recording.poses):
        return None
    if not path.is_file():
        raise SceneError("the mesh of the scene does not exist", path, "nothing", "a mesh", 'correct "mesh"')
    T = _pose(stretch)
    return None if T is None else _cast(read_mesh(path), camera, T)


def _pose(stretch: Stretch) -> NDArray[np.floating] | None:
    """(4, 4) pose of the camera at the middle of the stretch, from the nearest stated one."""
    poses = stretch.recording.poses
    assert poses is not None
    now = stretch.recording.timestamps[sum(stretch.frames) // 2]
    valid = np.flatnonzero(poses.valid)
    if not len(valid):
        return None
    return np.asarray(poses.poses[valid[np.abs(poses.timestamps[valid] - now).argmin()]], float)


def _cast(mesh: Mesh, camera: Camera, T_world_camera: NDArray[np.floating]) -> NDArray[np.floating]:
    import open3d as o3d

    tensor: Any = o3d.core.Tensor  # its stubs know no arrays

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
        tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
    )
    directions = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)]) @ T_world_camera[:3, :3].T
    starts = np.broadcast_to(T_world_camera[:3, 3], directions.shape)
    rays = np.concatenate([starts, directions], axis=2).astype(np.float32)
    # the ray (x, y, 1) is one metre deep, so its length counts depth
    depth = scene.cast_rays(tensor(rays))["t_hit"].numpy().astype(float)
    return np.asarray(np.where(np.isfinite(depth), depth, np.nan))
