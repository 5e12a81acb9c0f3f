"""Which part of space a frame can change: boxes around the views of the patches of its image."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, transform

FINE, COARSE = 8, 64  # [px] edge of a patch
BEHIND = 2.0  # truncations behind the surface that may change: one, and as much again for planes seen at a slant
ENDS = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, 8)


def shown(depth: NDArray[np.float32], camera: Camera, T_world_camera: Array, truncation: float) -> NDArray[np.float64]:
    """Boxes (n, 2, 3) [m, world] in which a frame has its surface and what is fused around it."""
    near, far, rays = _patches(depth, camera, FINE)
    return _boxes(np.maximum(near - BEHIND * truncation, 0.0), far + BEHIND * truncation, rays, T_world_camera)


def changed(
    depth: NDArray[np.float32], camera: Camera, T_world_camera: Array, truncation: float
) -> NDArray[np.float64]:
    """Boxes (n, 2, 3) [m, world] in which a frame changes voxels: there, and in all that is seen to be free."""
    near, far, rays = _patches(depth, camera, COARSE)
    return _boxes(np.zeros_like(near), far + BEHIND * truncation, rays, T_world_camera)


def _patches(depth: NDArray[np.float32], camera: Camera, edge: int) -> tuple[Array, Array, Array]:
    """Of the patches (n) that show a surface: nearest and farthest depth [m], and the least and largest x and y of
    their rays at depth 1 (n, 2, 2)."""
    known = np.isfinite(depth) & (depth > 0)

    def over(values: NDArray, empty: float, reduce: np.ufunc) -> Array:
        """Of each patch the least or largest value, (n, ...)."""
        filled = np.where(np.isnan(values), empty, values)
        rows = reduce.reduceat(filled, np.arange(0, camera.height, edge), axis=0)
        found = reduce.reduceat(rows, np.arange(0, camera.width, edge), axis=1)
        return found.reshape(-1, *values.shape[2:]).astype(float)

    near = over(np.where(known, depth, np.nan), np.inf, np.minimum)
    far = over(np.where(known, depth, np.nan), -np.inf, np.maximum)
    rays = camera.rays()
    side = 1.0 / min(camera.fx, camera.fy)  # a voxel belongs to the nearest pixel: half of one, and as much to be safe
    low, high = over(rays, np.inf, np.minimum) - side, over(rays, -np.inf, np.maximum) + side
    some = np.isfinite(near) & np.isfinite(low).all(axis=1)
    return near[some], far[some], np.stack([low, high], axis=1)[some]


def _boxes(near: Array, far: Array, rays: Array, T_world_camera: Array) -> Array:
    z = np.stack([near, far], axis=1)[:, ENDS[2]]
    corners = np.stack([rays[:, ENDS[0], 0] * z, rays[:, ENDS[1], 1] * z, z], axis=-1)
    world = transform(T_world_camera, corners)
    return np.stack([world.min(axis=1), world.max(axis=1)], axis=1)
