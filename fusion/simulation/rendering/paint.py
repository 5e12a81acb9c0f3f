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
    """A grey picture stretched over a rectangle."""

    picture: NDArray[np.uint8]  # (rows, columns) uint8; 0 has the reflectance `black`, 255 `white`
    T_world_picture: Array  # (4, 4): origin in the top-left corner, x to the right, y down, z into the surface
    size_m: tuple[float, float]  # width and height [m]
    # black, white: reflectances in the infrared
    black: float = 0.05
    white: float = 0.85
    turns: bool = False  # it stands on the turntable

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
    column, row = _cells(paint, rays, T_picture_camera)
    height, width = paint.picture.shape
    # around the picture lies one more row and column, in which nothing is painted: NaN would spoil the means
    grey = np.pad(paint.picture.astype(np.float32) / 255.0, 1)[row, column]
    inside = (row > 0) & (row <= height) & (column > 0) & (column <= width)
    share, total = _block_mean(inside.astype(np.float32)), _block_mean(grey)
    on = _lies_on(depth[rows, columns], camera.rays()[rows, columns], T_picture_camera)
    # a pixel half beside the pattern shows the mean of its painted half: what is beside it is not known here
    on &= share >= 0.5
    mask[rows, columns] = on
    return mask, (total / np.maximum(share, 1e-6))[on]


def _window(paint: Paint, depth: Image, camera: Camera, T_picture_camera: Array) -> tuple[slice, slice]:
    """Rows and columns that hold all pixels whose surface lies in the pattern's plane and near its rectangle."""
    rays = camera.rays()
    margin = 0.05 * max(paint.size_m)
    hit = _lies_on(depth, rays, T_picture_camera)
    with np.errstate(invalid="ignore"):
        for axis in range(2):
            place = depth * _times(T_picture_camera[axis, :3], rays[..., 0], rays[..., 1])
            place += float(T_picture_camera[axis, 3])
            hit &= (place > -margin) & (place < paint.size_m[axis] + margin)
    v, u = np.flatnonzero(hit.any(axis=1)), np.flatnonzero(hit.any(axis=0))
    if not len(v):
        return slice(0, 0), slice(0, 0)
    return slice(int(v[0]), int(v[-1]) + 1), slice(int(u[0]), int(u[-1]) + 1)


def _lies_on(depth: Image, rays: Image, T_picture_camera: Array) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        away = depth * _times(T_picture_camera[2, :3], rays[..., 0], rays[..., 1]) + float(T_picture_camera[2, 3])
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


def _cells(paint: Paint, rays: NDArray[np.float32], T: Array) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Column and row of the picture that rays meet, from 1; 0 or beyond the last where they do not meet it.

    From rays (x, y, 1) to the plane is a homography: with P = t + s R ray and P_z = 0, P_x = (t_x R_z - t_z R_x) ray /
    (R_z ray).
    """
    R, t = T[:3, :3], T[:3, 3]
    x, y = rays[..., 0], rays[..., 1]
    below = _times(R[2], x, y)
    cells = []
    for axis in range(2):
        count = paint.picture.shape[1 - axis]
        above = _times((t[axis] * R[2] - t[2] * R[axis]) * (count / paint.size_m[axis]), x, y)
        with np.errstate(all="ignore"):
            cell = np.floor(above / below) + 1
            # behind the camera, or along the plane
            cell = np.where(-float(t[2]) * below > 0, np.clip(np.nan_to_num(cell), 0, count + 1), 0)
        cells.append(cell.astype(np.int32))
    return cells[0], cells[1]


def _times(row: Array, x: Image, y: Image) -> Image:
    # plain numbers keep single precision: a thousandth of a cell
    return float(row[0]) * x + float(row[1]) * y + float(row[2])


def _block_mean(fine: Image) -> Image:
    h, w = fine.shape
    return fine.reshape(h // ACROSS, ACROSS, w // ACROSS, ACROSS).mean(axis=(1, 3))
