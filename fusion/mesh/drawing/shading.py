"""From what is seen to a picture: soft light from the upper left, edges deepened, background transparent."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.geometry.pose import Array
from fusion.mesh.drawing.sight import Sight, SightSide, look, sides
from fusion.mesh.mesh import Mesh

CLAY = (0.80, 0.81, 0.83)  # colour of a mesh that has none


@dataclass(frozen=True)
class Lit:
    """A sight in its light, which is the same whatever colours are shown in it."""

    sight: Sight  # what the pixels show
    light: NDArray[np.float32]  # (k,) brightness of the k pixels that were hit
    inside: NDArray[np.bool_]  # (k,) whether they show the surface from behind, through a hole

    @property
    def side(self) -> SightSide:
        """Where it was looked from."""
        return self.sight.side


def lit(sight: Sight, normals: NDArray) -> Lit:
    """Light on what is seen of a mesh with vertex normals (n, 3)."""
    light, inside = _light(sight, normals)
    return Lit(sight, (light * _edges(sight)[sight.hit]).astype(np.float32), inside)


def picture(seen: Lit, colors: NDArray | None = None) -> NDArray[np.uint8]:
    """An RGBA picture (h // 2, w // 2, 4) in the vertices' colours (n, 3), 0 to 1, or clay; every pixel the mean of
    2 x 2 looked-at ones."""
    hit = seen.sight.hit
    rgba = np.zeros((*hit.shape, 4), np.float32)
    base = np.full((len(seen.light), 3), CLAY, np.float32) if colors is None else seen.sight.values(colors)
    base[seen.inside] = 0.35 * base[seen.inside] + 0.1  # seen from behind, through a hole: dark
    rgba[hit, :3] = np.clip(base * seen.light[:, None], 0, 1)
    rgba[hit, 3] = 1
    h, w = (n // 2 for n in hit.shape)
    mean = np.asarray(cv2.resize(rgba[: 2 * h, : 2 * w], (w, h), interpolation=cv2.INTER_AREA), np.float32)
    mean[..., :3] /= np.maximum(mean[..., 3:], 0.25)
    return (mean * 255 + 0.5).astype(np.uint8)


def vertex_normals(mesh: Mesh) -> NDArray[np.float32]:
    """The mesh's normals (n, 3), made from its triangles where it has none; zero for a bare point cloud."""
    if mesh.normals is not None and len(mesh.normals) == len(mesh.vertices):
        return np.nan_to_num(mesh.normals)
    normals = np.zeros((len(mesh.vertices), 3))
    if len(mesh.faces):
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        across = np.nan_to_num(np.cross(b - a, c - a))  # length is twice the area: large triangles count more
        for k in range(3):
            np.add.at(normals, mesh.faces[:, k], across)
    return (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)).astype(np.float32)


def _light(sight: Sight, normals: NDArray) -> tuple[NDArray, NDArray]:
    """Brightness (k,) of the pixels that were hit, and which of them (k,) show the surface from inside."""
    n = sight.values(normals)
    length = np.sqrt(np.einsum("ij,ij->i", n, n))
    n /= np.maximum(length, 1e-9)[:, None]
    # grazing triangles may turn away a little by interpolation: only a clear turn counts
    inside = n @ sight.side.towards < -0.15
    n[inside] *= -1
    side = sight.side
    key = 0.45 * side.up - 0.45 * side.right + 0.77 * side.towards
    bare = length < 0.5  # a cloud without normals: as if it faced the eye
    lit = 0.34 + 0.56 * np.clip(n @ key, 0, 1) + 0.14 * np.clip(n @ side.towards, 0, 1) + 0.08 * (n @ side.up)
    return np.where(bare, 0.95, lit), inside


def _edges(sight: Sight) -> NDArray[np.float32]:
    """Brightness (h, w), less where the surface drops behind its neighbours (eye-dome lighting, C. Boucheny 2009)."""
    depth = np.where(np.isfinite(sight.depth), sight.depth, np.nan)
    drop = np.zeros_like(depth)
    for reach in (2, 6):
        for dv, du in ((0, reach), (0, -reach), (reach, 0), (-reach, 0)):
            step = (depth - np.roll(depth, (dv, du), axis=(0, 1))) / (sight.pixel * reach)
            drop += np.clip(np.nan_to_num(step) - 1.0, 0, 6)  # slopes below 45 degrees keep their light
    return np.exp(-0.035 * drop).astype(np.float32)


PIXELS = 360  # of the mesh's longest edge
RISE = np.deg2rad(20)  # of the eye above the horizon
GAP = 20  # between the views [px]


def png(mesh: Mesh, up: ArrayLike = (0, 0, 1), front: ArrayLike = (1, 0, 0)) -> bytes | None:
    """A PNG with transparent background; None where there is nothing to see.

    Args:
        mesh: shown in its colours, else as clay.
        up: (3,) that points up in the picture.
        front: (3,) from the object to the eye of the first view.
    """
    level = sides(np.asarray(up, float), np.asarray(front, float))
    views = [shaded(mesh, raised(side), PIXELS) for side in (level[0], level[2])]
    if not any(view[..., 3].any() for view in views):
        return None
    height = max(len(view) for view in views)
    gap = np.zeros((height, GAP, 4), np.uint8)
    # all stand on the ground
    views = [np.pad(view, ((height - len(view), 0), (0, 0), (0, 0))) for view in views]
    return bytes(cv2.imencode(".png", np.hstack([views[0], gap, views[1]])[..., [2, 1, 0, 3]])[1])


def shaded(mesh: Mesh, side: SightSide, pixels: int) -> NDArray[np.uint8]:
    """RGBA (h, w, 4) from one side; `pixels` along the mesh's longest edge."""
    known = mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)]
    longest = float(np.ptp(known, axis=0).max()) if len(known) else 1.0
    colors = np.broadcast_to(CLAY, mesh.vertices.shape) if mesh.colors is None else mesh.colors / 255
    # two looked-at pixels for each of the picture
    return picture(lit(look(mesh, side, longest / (2 * pixels)), vertex_normals(mesh)), colors)


def raised(side: SightSide) -> SightSide:
    """The same side, seen from above by RISE."""
    towards: Array = np.cos(RISE) * side.towards + np.sin(RISE) * side.up
    return SightSide(side.name, towards, np.cos(RISE) * side.up - np.sin(RISE) * side.towards)
