# mypy: ignore-errors
"""Seeing the volume from a camera: the first place on each ray where the field goes from outside to inside."""

from dataclasses import dataclass

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.compute import parts
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64, Blocks
from fusion.volume.cast import COARSE, cast
from fusion.volume.lens import rows
from fusion.volume.sample import corners, place, slope, smooth
from fusion.volume.window import find, window

SPAN = 1.5  # voxels to either side over which a normal is taken from the depth image
PIECE = 32  # pixels of a row that are looked at in turn
BEND = 1.0  # voxels that its ends may lie beside the tangent


@dataclass(frozen=True)
class Raycast:
    """The surface as a camera sees it, in the CAMERA frame; NaN where nothing was seen.

    Attributes:
        depth: (h, w) float32, planar z [m].
        points: (h, w, 3) float32 [m].
        normals: (h, w, 3) float32 unit vectors towards the camera; NaN where nothing was hit.
        colors: (h, w, 3) uint8, 0 where unknown; None for a volume without colour.
    """

    depth: NDArray[np.float32]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    colors: NDArray[np.uint8] | None = None


def raycast(blocks: Blocks, camera: Camera, T_world_camera: Array, reach: tuple[float, float]) -> Raycast:
    """The surface seen by a camera at a pose (4, 4), between two depths `reach` = (near, far) [m]."""
    h, w = camera.shape
    depth = np.full((h, w), np.nan, np.float32)  # ten times as fast as in a kernel
    points, normals = np.full((h, w, 3), np.nan, np.float32), np.full((h, w, 3), np.nan, np.float32)
    colored = blocks.settings.color
    colors = np.zeros((h, w, 3) if colored else (1, 1, 3), np.uint8)
    seen = window(blocks, camera, T_world_camera, (max(reach[0], 1e-4), reach[1]))
    table = (blocks.keys, blocks.ids, seen.low, seen.size, seen.grid, blocks.solid, blocks.neighbours, blocks.flat)
    T, voxel = rows(T_world_camera), blocks.settings.voxel
    down, across = np.nonzero(seen.last)
    tiles = (down << 16 | across).astype(np.int32)
    for step in (COARSE, 2, 1):
        cast(
            step, *table, camera.rays(), T, seen.first, seen.last, tiles, len(tiles), voxel, camera.fx, depth,
            np.zeros(1, np.int32), parts(),
        )  # fmt: skip
    _shade(*table, blocks.colors, camera.rays(), T, voxel, camera.fx, depth, points, normals, colors, colored)
    return Raycast(depth, points, normals, colors if colored else None)


@ti.func
def _across(v: ti.i32, u: ti.i32, step: ti.i32, depth: ti.template(), rays: ti.template(), voxel: ti.f32):
    """Normal (3,), of any length, through the surface points `step` pixels to all four sides; 0 unless they lie as on
    one smooth surface. Over the same distance as the field's gradient it is as exact, and found much faster."""
    height, width = depth.shape[0], depth.shape[1]
    g = ti.Vector([0.0, 0.0, 0.0])
    if v >= step and u >= step and v + step < height and u + step < width:
        z, left, right = depth[v, u], depth[v, u - step], depth[v, u + step]
        up, down = depth[v - step, u], depth[v + step, u]
        # of NaN it is not true
        if ti.abs(left + right - 2.0 * z) < BEND * voxel and ti.abs(up + down - 2.0 * z) < BEND * voxel:
            a = ti.Vector([rays[v, u + step, 0], rays[v, u + step, 1], 1.0]) * right
            a -= ti.Vector([rays[v, u - step, 0], rays[v, u - step, 1], 1.0]) * left
            b = ti.Vector([rays[v + step, u, 0], rays[v + step, u, 1], 1.0]) * down
            b -= ti.Vector([rays[v - step, u, 0], rays[v - step, u, 1], 1.0]) * up
            g = b.cross(a)
    return g


@ti.kernel
def _shade(
    keys: I64, ids: I32, low: I32, size: I32, grid: I32, solid: I32, neighbours: I32_2, voxels: F32, colors: F32_3,
    rays: F32_3, pose: F32, voxel: ti.f32, focal: ti.f32, depth: F32_2, points: F32_3, normals: F32_3,
    image: ti.types.ndarray(ti.u8, 3), colored: ti.template(),
):  # fmt: skip
    """Fills in points, normals (both NaN before) and colours where rays end."""
    width = depth.shape[1]
    across = (width + PIECE - 1) // PIECE
    for piece in range(depth.shape[0] * across):  # a division for every pixel would take as long as the rest
        row, start = piece // across, piece % across * PIECE
        for col in range(start, ti.min(start + PIECE, width)):
            hit = depth[row, col]
            if hit > 0.0:
                R = ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
                ray = ti.Vector([rays[row, col, 0], rays[row, col, 1], 1.0])
                span = ti.cast(ti.ceil(SPAN * voxel * focal / hit), ti.i32)
                g = _across(row, col, span, depth, rays, voxel)
                known = g.dot(ray) < 0.0  # else at a step, a crease or an end
                if not known or ti.static(colored):
                    d = R @ ray / voxel
                    p = ti.Vector([pose[3], pose[7], pose[11]]) / voxel + d * hit
                    base = ti.cast(ti.floor(p), ti.i32)
                    n = find(base >> 3, low, size, grid, keys, ids)
                    cell = base & 7
                    if n >= 0 and not known:
                        f, _lowest = corners(n, cell[0], cell[1], cell[2], neighbours, voxels)
                        g = smooth(n, cell, p - base, f, neighbours, voxels)
                        if g.dot(d) >= 0.0:  # unknown, or turned away by what lies behind
                            g = slope(f, p - base)
                        g = R.transpose() @ g
                        known = g.dot(ray) < 0.0
                    if ti.static(colored):  # noqa: SIM102
                        if n >= 0:
                            near = ti.cast(ti.floor(p + 0.5), ti.i32) - (base - cell)
                            b, o = place(n, near[0], near[1], near[2], neighbours)
                            if b >= 0 and colors[b, o, 3] > 0.0:
                                for a in ti.static(range(3)):
                                    image[row, col, a] = ti.cast(colors[b, o, a] / colors[b, o, 3] + 0.5, ti.u8)
                for a in ti.static(range(3)):
                    points[row, col, a] = ray[a] * hit
                    if known:
                        normals[row, col, a] = g[a] / g.norm()
