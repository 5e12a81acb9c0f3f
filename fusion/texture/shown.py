"""What a camera sees of a textured mesh, and the photographs that it was made of beside it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.images import bilinear
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.mesh.comparison.surface_samples import unit
from fusion.mesh.mesh import Mesh
from fusion.texture.lighting.light import Facings, Lighting
from fusion.texture.textured import Textured

MARGIN = 0.06  # of the object's size, left around it in a picture


@dataclass(frozen=True)
class PhotoPair:
    """A photograph, and the textured mesh from the same place."""

    frame: int  # of the recording
    # photograph, texture: (h, w, 3) uint8 RGB, cut to the object
    photograph: NDArray[np.uint8]
    texture: NDArray[np.uint8]
    shown: NDArray[np.bool_]  # (h, w) where the mesh is seen


def beside_photographs(made: Textured, count: int) -> Iterator[PhotoPair]:
    """Up to `count` photographs, spread over those that a texture was made of, with the texture as seen from each, in
    its light and exposure."""
    views = made.views
    for number in np.unique(np.linspace(0, len(views.frames), count, endpoint=False).astype(int)):
        source = views.sources[number]
        try:
            image = source.read(views.frames[number])
        except RecordingError:  # damaged: the texture was made without it
            continue
        if image is None:
            continue
        light = made.lights[views.recordings[number]]
        colors, depth = seen_texture(made, source.camera, views.T_world_color[number], light)
        shown = np.isfinite(depth)
        if shown.any():
            cut = _around(shown)
            texture = np.clip(np.rint(colors[cut] / made.gain[number]), 0, 255).astype(np.uint8)
            yield PhotoPair(views.frames[number], image.color[cut], texture, shown[cut])


def seen_texture(
    made: Textured, camera: Camera, T: Array, light: Lighting | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """(h, w, 3) what a camera at a pose (4, 4) sees of a textured mesh [counts], below a light or evenly lit, and its
    depth (h, w) [m]; black and infinite beside it."""
    face, share, depth = seen_faces(made.mesh, camera, T)
    h, w = made.image.shape[:2]
    known = np.isfinite(depth)
    uv = (made.uv[made.mesh.faces[face[known]]] * share[known][..., None]).sum(axis=1)
    out = np.zeros((*depth.shape, 3))
    out[known] = bilinear(made.image, np.column_stack([uv[:, 0] * w - 0.5, (1 - uv[:, 1]) * h - 0.5]))
    if light is not None:
        out[known] *= light.on(facing(made.mesh, T, face[known], share[known]))
    return out, depth


def facing(mesh: Mesh, T: Array, face: NDArray[Any], share: NDArray[np.float64]) -> Facings:
    """Places on a mesh with normals before a camera at a pose (4, 4): on faces (k,), by shares of corners (k, 3)."""
    corners = mesh.faces[face]
    points = ((mesh.vertices[corners] * share[..., None]).sum(axis=1) - T[:3, 3]) @ T[:3, :3]
    normals = unit((np.asarray(mesh.normals, float)[corners] * share[..., None]).sum(axis=1)) @ T[:3, :3]
    return Facings(points.astype(np.float32), normals.astype(np.float32))


def seen_faces(mesh: Mesh, camera: Camera, T: Array) -> tuple[NDArray[Any], NDArray[np.float64], NDArray[np.float32]]:
    """Face (h, w), shares of its corners (h, w, 3) and depth (h, w) [m] that a camera at a pose (4, 4) sees."""
    import open3d as o3d

    tensor, scene = o3d.core.Tensor.from_numpy, o3d.t.geometry.RaycastingScene()
    local = replace(mesh, vertices=(mesh.vertices - T[:3, 3]) @ T[:3, :3])
    scene.add_triangles(tensor(local.vertices.astype(np.float32)), tensor(mesh.faces.astype(np.uint32)))
    rays = np.zeros((*camera.shape, 6), np.float32)
    rays[..., 3:] = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)])
    hit = scene.cast_rays(tensor(rays))
    b, c = np.moveaxis(hit["primitive_uvs"].numpy().astype(float), -1, 0)
    face = hit["primitive_ids"].numpy().astype(np.int64)
    return face, np.stack([1 - b - c, b, c], axis=-1), hit["t_hit"].numpy()


def _around(shown: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Rows and columns of what is shown, and a margin."""
    v, u = np.nonzero(shown)
    edge = int(MARGIN * max(np.ptp(v), np.ptp(u))) + 1
    return np.s_[max(v.min() - edge, 0) : v.max() + edge + 1, max(u.min() - edge, 0) : u.max() + edge + 1]
