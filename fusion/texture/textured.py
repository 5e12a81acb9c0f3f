"""A mesh with a picture on it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from fusion.coloring.color_mesh import color_from
from fusion.errors import MeshError, RecordingError
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.comparison.surface_samples import unit, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.printing.fewer import decimated
from fusion.progress import stage
from fusion.recording.recording import Recording
from fusion.texture.atlas import Atlas, laid_flat
from fusion.texture.lighting.light import Lighting
from fusion.texture.other_mesh import apart
from fusion.texture.paint import painted
from fusion.texture.views import Views

TRIANGLES = 10_000  # a scan to a tenth of a millimetre or two, and flat in a second; phones are quick with it
OVERSAMPLED = 2.5  # texels along a pixel: each is looked up between four twice, in the image and in the texture


@dataclass(frozen=True)
class Textured:
    """A mesh with a picture on it."""

    mesh: Mesh  # with normals, z up; a vertex at a seam is there once for each side
    uv: NDArray[np.float64]  # (n, 2) place of each vertex in the picture, 0 to 1, u to the right, v upwards
    image: NDArray[np.uint8]  # (h, w, 3) uint8 RGB
    texel: float  # edge of a texel on the surface [m]
    moved: tuple[float, float]  # rms and largest distance from the scan [m], as far as both show the same
    images: int  # how many colour images were used
    gain: NDArray[np.float32]  # (views, 3) by which factor each was made brighter
    unseen_share: float  # of the surface, shown by no image: there the colour is that of the vertices around, or grey
    views: Views  # the images, where the print says that their cameras were
    lights: list[Lighting]  # before the camera of each recording; the picture shows the colours without them

    def values(self) -> dict[str, float]:
        """What `texture.json` tells."""
        return {
            "triangles": len(self.mesh.faces),
            "width": self.image.shape[1],
            "height": self.image.shape[0],
            "texel_m": self.texel,
            "moved_rms_m": self.moved[0],
            "moved_max_m": self.moved[1],
            "images": self.images,
            "gain_min": float(self.gain.min()),
            "gain_max": float(self.gain.max()),
            "light_min": min(float(np.exp(light.known[0].min())) for light in self.lights),
            "light_max": max(float(np.exp(light.known[1].max())) for light in self.lights),
            "unseen_share": self.unseen_share,
        }


def texture_mesh(
    mesh: Mesh,
    taken: Sequence[tuple[Recording, Trajectory]],
    triangles: int = TRIANGLES,
    texel: float | None = None,
    scan: Mesh | None = None,
) -> Textured:
    """Lay the colour images of recordings on a mesh that was made from them.

    Args:
        mesh: triangles in the world of the trajectories [m]; its own colours stand where no image looks.
        taken: recordings, each with the trajectory (frames) `T_world_camera` of its depth camera.
        triangles: at most so many are left of the mesh.
        texel: edge of a texel on the surface [m]; None: two fifths of what a pixel covers.
        scan: the mesh of the recordings, where `mesh` is another one of the object.

    Raises:
        MeshError: no triangles, or no image shows them.
        RecordingError: no colour image that can be used.
    """
    if not len(mesh.faces):
        raise MeshError("a texture needs triangles", "mesh", f"{len(mesh.vertices)} points", "a mesh")
    views = Views.of(taken)
    if not views.frames:
        where = ", ".join(str(recording.path) for recording, _ in taken)
        raise RecordingError("there is no colour image to make a texture of", where, do="record colour too")
    if mesh.normals is None:
        mesh = replace(mesh, normals=vertex_normals(mesh).astype(np.float32))
    if mesh.colors is None:
        mesh = color_from(mesh, taken).mesh
    if mesh.colors is None:
        where = ", ".join(str(recording.path) for recording, _ in taken)
        expected = "images of the colour camera's size"
        raise RecordingError("no colour image can be used", where, "damaged or of another size", expected)
    with stage("atlas"):
        less = decimated(replace(mesh, scalars={}), triangles)
        centre = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2
        atlas = laid_flat(less, texel or views.pixel(centre) / OVERSAMPLED)
        texels = texels_of(atlas)
        off = apart(scan or mesh, less)
    found = painted(texels.points, mesh, views)
    colors = found.colors
    unseen = np.flatnonzero(~found.seen)
    _, nearest = cKDTree(mesh.vertices).query(texels.points.vertices[unseen])
    colors[unseen] = np.asarray(mesh.colors)[nearest]
    return Textured(
        replace(atlas.mesh, colors=None),
        atlas.uv,
        texels.picture(colors),
        texel_of(atlas.mesh, atlas.uv * [atlas.width, atlas.height]),
        (float(np.sqrt(np.mean(off**2))), float(off.max())),
        found.images,
        found.gain,
        float(np.mean(~found.seen)) if len(found.seen) else 0.0,
        found.views,
        found.lights,
    )


def texel_of(mesh: Mesh, places: NDArray[np.float64]) -> float:
    """Edge of a texel on the surface [m], from the places (n, 2) of the vertices in the picture [texels]."""
    a, b, c = (places[mesh.faces[:, i]] for i in range(3))
    (x, y), (z, w) = (b - a).T, (c - a).T
    flat = float(np.abs(x * w - y * z).sum() / 2)
    p, q, r = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    area = float(np.linalg.norm(np.cross(q - p, r - p), axis=1).sum() / 2)
    return float(np.sqrt(area / max(flat, 1e-12)))


@dataclass(frozen=True)
class Texels:
    """The texels whose middle lies in a triangle."""

    shape: tuple[int, int]  # rows and columns of the picture
    at: NDArray[np.int64]  # (k,) their places in the picture, row by row from the top
    points: Mesh  # their places on the surface [m], as a point cloud with normals

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
