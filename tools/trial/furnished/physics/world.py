"""What rays meet."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d

from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.rooms.parts import MergedParts

o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)


@dataclass(frozen=True)
class SeenPixels:
    """What each pixel sees; NaN where nothing is.

    Attributes:
        z: (h, w) [m] depth along the optical axis.
        range: (h, w) [m] along the ray.
        cosine: (h, w) of the angle between ray and normal.
        reflectance: (h, w).
        part: (h, w) index, -1 for nothing.
        normal: (h, w, 3) in the camera's frame, towards it.
        stretch: (h, w) range over z.
        direction: (h, w, 3) with z = 1.
    """

    z: Array
    range: Array
    cosine: Array
    reflectance: Array
    part: Array
    normal: Array
    stretch: Array
    direction: Array


class World:
    def __init__(self, merged: MergedParts) -> None:
        self.mesh = merged
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=2)
        triangles = o3d.core.Tensor.from_numpy(merged.faces.astype(np.uint32))
        self._scene.add_triangles(o3d.core.Tensor.from_numpy(merged.vertices.astype(np.float32)), triangles)

    def cast(self, T: Array, direction: Array) -> SeenPixels:
        """`T` (4, 4), or (h, 4, 4) one for each row; `direction` (h, w, 3) with z = 1."""
        rows = np.broadcast_to(T, (direction.shape[0], 4, 4))
        turn = rows[:, :3, :3]
        ray = np.einsum("hij,hwj->hwi", turn, direction)
        origin = np.broadcast_to(rows[:, None, :3, 3], ray.shape)
        answer = self._scene.cast_rays(o3d.core.Tensor.from_numpy(np.concatenate([origin, ray], -1).astype(np.float32)))
        face = answer["primitive_ids"].numpy().astype(np.int64)
        hit = face < len(self.mesh.faces)
        face[~hit] = 0
        # the triangle comes from single precision, where the ray meets its plane from double
        corners = self.mesh.vertices.astype(float)[self.mesh.faces[face]]
        normal = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
        slope = (normal * ray).sum(-1)
        slope = np.where(np.abs(slope) < 1e-9, 1e-9, slope)
        z = ((corners[..., 0, :] - origin) * normal).sum(-1) / slope
        z = np.where(hit, z, np.nan)
        stretch = np.linalg.norm(direction, axis=-1)
        normal = normal * -np.sign(slope)[..., None]
        return SeenPixels(
            z,
            z * stretch,
            np.abs(slope) / stretch,
            self.mesh.reflectance[face],
            np.where(hit, self.mesh.part[face], -1),
            np.einsum("hji,hwj->hwi", turn, normal),
            stretch,
            direction,
        )

    def blocked(self, start: Array, end: Array) -> Array:
        """Whether something is between points (..., 3); the caller lifts the start off its surface."""
        rays = o3d.core.Tensor.from_numpy(np.concatenate([start, end - start], -1).astype(np.float32))
        return np.asarray(self._scene.test_occlusions(rays, 0.0, 0.995).numpy())
