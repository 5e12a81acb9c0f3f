"""A fine pattern on a flat surface: sharper than any mesh, each pixel the mean of the area that it sees."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SceneError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.sensor.view import Image

ACROSS = 4  # rays a pixel is divided into, along each side
NEAR = 2e-4  # a surface this close to the pattern's plane carries it, as share of the depth: ten times the rounding


@dataclass(frozen=True)
class Paint:
    """A grey picture stretched over a rectangle.

    Attributes:
        picture: (rows, columns) uint8; 0 has the reflectance `black`, 255 `white`.
        T_world_picture: (4, 4): origin in the top-left corner, x to the right, y down, z into the surface.
        size_m: width and height [m].
        black, white: reflectances in the infrared.
        turns: it stands on the turntable.
    """

    picture: NDArray[np.uint8]
    T_world_picture: Array
    size_m: tuple[float, float]
    black: float = 0.05
    white: float = 0.85
    turns: bool = False

    def __post_init__(self) -> None:
        if not (0 <= self.black <= 1 and 0 <= self.white <= 1):
            raise SceneError("a reflectance cannot be used", found=f"{self.black}, {self.white}", expected="0 to 1")
        if not (min(self.size_m) > 0 and np.isfinite(self.size_m).all()):
            raise SceneError("a pattern has no size", found=self.size_m, expected="two lengths above 0 m")


def painted(paint: Paint, depth: Image, camera: Camera, T_picture_camera: Array) -> tuple[NDArray[np.bool_], Image]:
    """Where an image (h, w) shows the pattern, and its grey there (n,), 0 to 1, as mean over each pixel's area.

    Args:
        depth: (h, w) planar z [m] of what the pixels see.
        T_picture_camera: (4, 4).
    """
    rows, columns = _window(paint, depth, camera, T_picture_camera)
    mask = np.zeros(depth.shape, bool)
    if rows.start == rows.stop:
        return mask, np.zeros(0)
    rays = _fine_rays(camera)[rows.start * ACROSS : rows.stop * ACROSS, columns.start * ACROSS : columns.stop * ACROSS]
    u, v = _on_plane(rays, T_picture_camera)
    height, width = paint.picture.shape
    column, row = np.floor(u / paint.size_m[0] * width), np.floor(v / paint.size_m[1] * height)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    at = np.where(inside, row, 0).astype(np.intp), np.where(inside, column, 0).astype(np.intp)
    grey = np.where(inside, paint.picture[at], 0).astype(np.float32) / 255.0
    share, total = _block_mean(inside.astype(np.float32)), _block_mean(grey)
    on = _lies_on(depth[rows, columns], camera.rays()[rows, columns], T_picture_camera)
    # a pixel half beside the pattern shows the mean of its painted half: what is beside it is not known here
    on &= share >= 0.5
    mask[rows, columns] = on
    return mask, (total / np.maximum(share, 1e-6))[on]


def _window(paint: Paint, depth: Image, camera: Camera, T_picture_camera: Array) -> tuple[slice, slice]:
    """Rows and columns that hold all pixels whose surface lies in the pattern's plane and near its rectangle."""
    rays = camera.rays()
    points = np.dstack([rays, np.ones(depth.shape, np.float32)]) * depth[..., None]
    local = points @ T_picture_camera[:3, :3].T + T_picture_camera[:3, 3]
    margin = 0.05 * max(paint.size_m)
    with np.errstate(invalid="ignore"):
        hit = np.abs(local[..., 2]) < NEAR * (1 + depth)
        for axis in range(2):
            hit &= (local[..., axis] > -margin) & (local[..., axis] < paint.size_m[axis] + margin)
    v, u = np.flatnonzero(hit.any(axis=1)), np.flatnonzero(hit.any(axis=0))
    if not len(v):
        return slice(0, 0), slice(0, 0)
    return slice(int(v[0]), int(v[-1]) + 1), slice(int(u[0]), int(u[-1]) + 1)


def _lies_on(depth: Image, rays: Image, T_picture_camera: Array) -> NDArray[np.bool_]:
    z = T_picture_camera[2, :3]
    with np.errstate(invalid="ignore"):
        away = depth * (rays[..., 0] * z[0] + rays[..., 1] * z[1] + z[2]) + T_picture_camera[2, 3]
        return np.asarray(np.abs(away) < NEAR * (1 + depth))


def _fine_rays(camera: Camera) -> NDArray[np.float32]:
    """(ACROSS h, ACROSS w, 2) rays of the middles of the parts of every pixel."""
    shift = (ACROSS - 1) / 2
    fine = replace(
        camera,
        width=camera.width * ACROSS,
        height=camera.height * ACROSS,
        fx=camera.fx * ACROSS,
        fy=camera.fy * ACROSS,
        cx=camera.cx * ACROSS + shift,
        cy=camera.cy * ACROSS + shift,
        std={},
    )
    return fine.rays()


def _on_plane(rays: NDArray[np.float32], T_picture_camera: Array) -> tuple[Image, Image]:
    """x and y [m] in the picture's plane of each ray; far outside where a ray does not meet it."""
    R, t = T_picture_camera[:3, :3], T_picture_camera[:3, 3]
    x, y, z = (rays[..., 0] * R[k, 0] + rays[..., 1] * R[k, 1] + R[k, 2] for k in range(3))
    with np.errstate(all="ignore"):
        length = -t[2] / z
        good = np.isfinite(length) & (length > 0)
        return np.where(good, t[0] + length * x, -1e9), np.where(good, t[1] + length * y, -1e9)


def _block_mean(fine: Image) -> Image:
    h, w = fine.shape
    return fine.reshape(h // ACROSS, ACROSS, w // ACROSS, ACROSS).mean(axis=(1, 3))
