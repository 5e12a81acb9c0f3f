"""What of a mesh is seen from one side, in parallel projection: rays through Open3D's ray-casting scene."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh


@dataclass(frozen=True)
class SightSide:
    """A direction to look from."""

    name: str  # "front", "left", ..
    towards: Array  # (3,) unit vector from the object to the eye
    up: Array  # (3,) unit vector that points up in the picture

    @property
    def right(self) -> Array:
        """(3,) unit vector that points right in the picture."""
        return np.cross(self.up, self.towards)


@dataclass(frozen=True)
class Sight:
    """What each pixel of a picture [row from the top, column] shows."""

    side: SightSide  # where it was looked from
    hit: NDArray[np.bool_]  # (h, w) pixels that show the object, k of them
    corners: NDArray[np.integer]  # (3, k) int, vertices of the triangle that was hit
    weights: NDArray[np.float32]  # (3, k) how much each of them counts
    depth: NDArray[np.float32]  # (h, w) [m] along the view, infinite where nothing was hit
    pixel: float  # [m] edge of a pixel

    def values(self, per_vertex: NDArray) -> NDArray[np.float32]:
        """Values (k, c) of the k pixels that were hit, between those at the vertices (n, c)."""
        values = np.ascontiguousarray(per_vertex, np.float32)
        total = np.zeros((self.corners.shape[1], values.shape[1]), np.float32)
        for corner, weight in zip(self.corners, self.weights, strict=True):
            total += weight[:, None] * np.take(values, corner, axis=0)
        return total


def sides(up: Array, front: Array) -> list[SightSide]:
    """Front, left, back, right and top; `front` (3,) points from the object to the eye, made square to `up` (3,)."""
    up = _unit(up, np.array([0.0, 0.0, 1.0]))
    helper = np.eye(3)[np.argmin(np.abs(up))]
    front = _unit(front - up * (front @ up), _unit(np.cross(up, helper), helper))
    right = np.cross(up, front)
    around = [SightSide(n, d, up) for n, d in [("front", front), ("left", -right), ("back", -front), ("right", right)]]
    return [*around, SightSide("top", up, -front)]


def look(mesh: Mesh, side: SightSide, pixel: float) -> Sight:
    """Look at a mesh, or at a point cloud, from one side with pixels of the given size [m]."""
    return look_around(mesh, [side], pixel)[0]


def look_around(mesh: Mesh, sides: Sequence[SightSide], pixel: float) -> list[Sight]:
    """Look from several sides: the tree that the rays ask is made once."""
    points = mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)]
    if len(points) == 0:
        return [_nothing(side, pixel) for side in sides]
    body = _Body(mesh) if len(mesh.faces) else None
    return [_look(mesh, body, side, points, pixel) for side in sides]


def _look(mesh: Mesh, body: "_Body | None", side: SightSide, points: Array, pixel: float) -> Sight:
    frame = np.stack([side.right, side.up, side.towards])
    turned = frame @ points.T
    low, high = turned.min(axis=1), turned.max(axis=1)
    pixel = max(pixel, 1e-9)
    width, height = (np.ceil((high - low)[:2] / pixel).astype(int) + 4).tolist()
    corner = np.array([low[0] - 1.5 * pixel, high[1] + 1.5 * pixel, high[2]])
    shape = (min(height, 4096), min(width, 4096))
    return _splats(mesh, side, corner, shape, pixel) if body is None else _rays(body, side, corner, shape, pixel)


class _Body:
    """A mesh as rays ask for it, about its middle: that keeps single precision exact enough."""

    def __init__(self, mesh: Mesh) -> None:
        import open3d as o3d

        finite = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
        self.faces = mesh.faces[finite[mesh.faces].all(axis=1)]
        self.middle = mesh.vertices[finite].mean(axis=0)
        local = np.nan_to_num(mesh.vertices - self.middle).astype(np.float32)
        faces = o3d.core.Tensor.from_numpy(self.faces.astype(np.uint32))
        self.scene = o3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(o3d.core.Tensor.from_numpy(local), faces)

    def cast(self, rays: NDArray[np.float32]) -> Any:
        import open3d as o3d

        return self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays))


def _rays(body: _Body, side: SightSide, corner: Array, shape: tuple[int, int], pixel: float) -> Sight:
    right, up = side.right * pixel, side.up * pixel
    # a pixel before the nearest point
    first = corner @ np.stack([side.right, side.up, side.towards]) + pixel * side.towards - body.middle
    v, u = np.arange(shape[0])[:, None], np.arange(shape[1])
    rays = np.empty((*shape, 6), np.float32)
    for k in range(3):  # one after the other: three values side by side cost numpy many times as much
        rays[..., k], rays[..., 3 + k] = first[k] + u * right[k] - v * up[k], -side.towards[k]
    answer = body.cast(rays)
    depth, triangle, uv = (answer[k].numpy() for k in ("t_hit", "primitive_ids", "primitive_uvs"))
    hit = np.isfinite(depth)
    corners = np.ascontiguousarray(np.take(body.faces, triangle[hit], axis=0).T)
    second, third = np.ascontiguousarray(uv[hit].T)
    return Sight(side, hit, corners, np.stack([1 - (second + third), second, third]), depth, pixel)


def _splats(mesh: Mesh, side: SightSide, corner: Array, shape: tuple[int, int], pixel: float) -> Sight:
    """Points as small squares, the nearest wins; the squares close the gaps of a dense cloud."""
    known = np.flatnonzero(np.isfinite(mesh.vertices).all(axis=1))
    local = mesh.vertices[known] @ np.stack([side.right, side.up, side.towards]).T - corner
    order = np.argsort(local[:, 2], kind="stable")  # far first, near drawn over it
    index, local = known[order], local[order]
    reach = int(np.clip(round(0.5 * np.sqrt(shape[0] * shape[1] / max(len(index), 1))), 1, 6))
    depth = np.full(shape, np.inf, np.float32)
    u, v = (np.round(x / pixel).astype(int) for x in (local[:, 0], -local[:, 1]))
    inside = (v >= -reach) & (u >= -reach) & (v < shape[0] + reach) & (u < shape[1] + reach)
    nearest = np.full((shape[0] + 2 * reach, shape[1] + 2 * reach), -1)  # place in the order from far to near
    nearest[v[inside] + reach, u[inside] + reach] = np.flatnonzero(inside)  # of several, the last: the nearest
    nearest = np.maximum.reduce([nearest[k : k + shape[0]] for k in range(2 * reach + 1)])
    nearest = np.maximum.reduce([nearest[:, k : k + shape[1]] for k in range(2 * reach + 1)])
    hit = nearest >= 0
    shown = nearest[hit]
    depth[hit] = -local[shown, 2]
    weights = np.zeros((3, len(shown)), np.float32)
    weights[0] = 1
    return Sight(side, hit, np.tile(index[shown], (3, 1)), weights, depth, pixel)


def _nothing(side: SightSide, pixel: float) -> Sight:
    shape, none = (8, 8), np.zeros((3, 0), np.int64)
    return Sight(side, np.zeros(shape, bool), none, none.astype(np.float32), np.full(shape, np.inf, np.float32), pixel)


def _unit(vector: Array, otherwise: Array) -> Array:
    length = np.linalg.norm(vector)
    return vector / length if np.isfinite(length) and length > 1e-9 else otherwise
