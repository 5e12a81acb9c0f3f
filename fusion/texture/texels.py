"""Which texels of a picture lie on the surface, and where there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from fusion.mesh.comparison.surface_samples import unit
from fusion.mesh.mesh import Mesh
from fusion.texture.atlas import Atlas


@dataclass(frozen=True)
class Texels:
    """The texels whose middle lies in a triangle.

    Attributes:
        shape: rows and columns of the picture.
        at: (k,) their places in the picture, row by row from the top.
        points: their places on the surface [m], as a point cloud with normals.
    """

    shape: tuple[int, int]
    at: NDArray[np.int64]
    points: Mesh

    def picture(self, colors: NDArray[np.float32]) -> NDArray[np.uint8]:
        """(h, w, 3) of colours (k, 3); beside the surface each texel is as the nearest one on it."""
        h, w = self.shape
        bare = np.ones(h * w, bool)
        bare[self.at] = False
        nearest = distance_transform_edt(bare.reshape(h, w), return_distances=False, return_indices=True)
        full = np.zeros((h * w, 3), np.uint8)
        full[self.at] = np.clip(np.rint(colors), 0, 255)
        return full.reshape(h, w, 3)[tuple(nearest)]


def texels_of(atlas: Atlas) -> Texels:
    """The texels of an atlas."""
    import open3d as o3d

    h, w = atlas.height, atlas.width
    flat = np.zeros((len(atlas.uv), 3), np.float32)
    flat[:, :2] = atlas.uv * [w, h]
    tensor, scene = o3d.core.Tensor.from_numpy, o3d.t.geometry.RaycastingScene()
    scene.add_triangles(tensor(flat), tensor(atlas.mesh.faces.astype(np.uint32)))
    found: list[NDArray[np.int64]] = []
    points: list[NDArray[np.float64]] = []
    normals: list[NDArray[np.float64]] = []
    for start in range(0, h, step := max(1, 1_000_000 // w)):  # rows at once: rays take 24 bytes each
        rows = np.arange(start, min(start + step, h))
        rays = np.zeros((len(rows), w, 6), np.float32)
        rays[..., 0], rays[..., 1] = np.arange(w) + 0.5, (h - rows - 0.5)[:, None]
        rays[..., 2], rays[..., 5] = 1, -1
        hit = scene.cast_rays(tensor(rays))
        face = hit["primitive_ids"].numpy().ravel()
        known = np.flatnonzero(face != scene.INVALID_ID)
        b, c = hit["primitive_uvs"].numpy().reshape(-1, 2)[known].T.astype(float)
        share = np.stack([1 - b - c, b, c], axis=1)[..., None]
        corners = atlas.mesh.faces[face[known]]
        found.append(known + start * w)
        points.append((atlas.mesh.vertices[corners] * share).sum(axis=1))
        normals.append((np.asarray(atlas.mesh.normals)[corners] * share).sum(axis=1))
    where = Mesh(np.concatenate(points), normals=unit(np.concatenate(normals)).astype(np.float32))
    return Texels((h, w), np.concatenate(found), where)
