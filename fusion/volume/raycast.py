# mypy: ignore-errors
"""Seeing the volume from a camera: the first place on each ray where the field goes from outside to inside."""

from dataclasses import dataclass

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64, Blocks, lookup
from fusion.volume.lens import in_cone, lens, load, project, rows
from fusion.volume.sample import blend, corners, place, slope, smooth, value
from fusion.volume.settings import BLOCK

TILE = 8  # pixels along the edge of a tile that shares one range of depths
CLOSE = 0.02  # voxels from the surface at which a straight line finds it


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
    depth = np.empty((h, w), np.float32)
    points, normals = np.empty((h, w, 3), np.float32), np.empty((h, w, 3), np.float32)
    colored = blocks.settings.color
    colors = np.zeros((h, w, 3) if colored else (1, 1, 3), np.uint8)
    tiles = (-(-h // TILE), -(-w // TILE))
    first, last = np.full(tiles, 1e30, np.float32), np.zeros(tiles, np.float32)
    near, far = max(reach[0], 1e-4), reach[1]
    if blocks.count:
        _range(
            blocks.coordinates, blocks.count, blocks.solid, rows(inverse(T_world_camera)), lens(camera), blocks.settings.voxel,
            near, far, h, w, first, last, any(camera.distortion),
        )  # fmt: skip
    _cast(
        blocks.keys, blocks.ids, blocks.neighbours, blocks.flat, blocks.colors, camera.rays(),
        rows(T_world_camera), first, last, blocks.settings.voxel, depth, points, normals, colors, colored,
    )  # fmt: skip
    return Raycast(depth, points, normals, colors if colored else None)


@ti.kernel
def _range(
    coordinates: I32_2, count: ti.i32, solid: I32, pose: F32, camera: F32, voxel: ti.f32, near: ti.f32, far: ti.f32,
    height: ti.i32, width: ti.i32, first: F32_2, last: F32_2, distorted: ti.template(),
):  # fmt: skip
    # a ray ends in a cell with a corner behind the surface: up to one voxel around a solid block
    half = 4.5 * voxel
    radius = half * 1.7321
    deep = half * (ti.abs(pose[8]) + ti.abs(pose[9]) + ti.abs(pose[10]))  # the cube's extent along z
    for n in range(count):
        if solid[n] == 0:
            continue
        c = load(camera)
        p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
        q = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                       for a in ti.static(range(3))])  # fmt: skip
        z0 = ti.max(q[2] - deep, near)
        z1 = ti.min(q[2] + deep, far)
        if z0 < z1 and in_cone(q, radius, c):
            v0, u0, v1, u1 = 0, 0, height - 1, width - 1
            if q[2] - radius > 0.25 * radius:
                x = q[0] / q[2]
                y = q[1] / q[2]
                r = ti.sqrt(x * x + y * y)
                spread = radius * (1.0 + r) / (q[2] - radius)
                scale = 1.0
                outside = False
                if ti.static(distorted):
                    limit = ti.sqrt(c[12])
                    outside = r - spread > limit
                    scale = c[13]
                    if r > limit:  # draw the centre in to where the lens is known, and the ball with it
                        spread += r - limit
                        x *= limit / r * 0.9999
                        y *= limit / r * 0.9999
                u, v = project(x, y, c, distorted)
                if outside:
                    u = -1e9
                v0 = ti.cast(ti.max(v - spread * scale * c[1], 0.0), ti.i32)
                u0 = ti.cast(ti.max(u - spread * scale * c[0], 0.0), ti.i32)
                v1 = ti.cast(ti.floor(ti.min(v + spread * scale * c[1] + 1.0, height - 1.0)), ti.i32)
                u1 = ti.cast(ti.floor(ti.min(u + spread * scale * c[0] + 1.0, width - 1.0)), ti.i32)
            if v1 >= 0 and u1 >= 0 and v0 < height and u0 < width:
                for a in range(v0 // TILE, v1 // TILE + 1):
                    for b in range(u0 // TILE, u1 // TILE + 1):
                        if z0 < first[a, b]:
                            ti.atomic_min(first[a, b], z0)
                        if z1 > last[a, b]:
                            ti.atomic_max(last[a, b], z1)


@ti.func
def _field(p: ti.template(), keys: ti.template(), ids: ti.template(), neighbours: ti.template(),
           voxels: ti.template()):  # fmt: skip
    """Trilinear distance at p [voxels] and the lowest weight around; weight 0 where a voxel was never seen."""
    base = ti.cast(ti.floor(p), ti.i32)
    n = lookup(base[0] >> 3, base[1] >> 3, base[2] >> 3, keys, ids)
    distance = 0.0
    weight = 0.0
    if n >= 0:
        f, lowest = corners(n, base[0] & 7, base[1] & 7, base[2] & 7, neighbours, voxels)
        distance = blend(f, p - base)
        weight = lowest
    return distance, weight


@ti.kernel
def _cast(
    keys: I64, ids: I32, neighbours: I32_2, voxels: F32, colors: F32_3, rays: F32_3, pose: F32,
    first: F32_2, last: F32_2, voxel: ti.f32,
    depth: F32_2, points: F32_3, normals: F32_3, image: ti.types.ndarray(ti.u8, 3), colored: ti.template(),
):  # fmt: skip
    height, width = depth.shape[0], depth.shape[1]
    for pixel in range(height * width):
        row = pixel // width
        col = pixel % width
        R = ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
        ray = ti.Vector([rays[row, col, 0], rays[row, col, 1], 1.0])
        origin = ti.Vector([pose[3], pose[7], pose[11]]) / voxel
        d = R @ ray / voxel  # [voxels per metre of depth]
        t = first[row // TILE, col // TILE]
        end = last[row // TILE, col // TILE]
        quantum = 1.0 / d.norm()  # depth of one voxel's length [m]
        before, t_before = -1.0, t  # the last value known to be outside; negative = none
        n, at = -1, ti.Vector([1 << 30, 0, 0])  # the block looked up last
        hit = -1.0
        while t < end and hit < 0.0:
            p = origin + d * t
            base = ti.cast(ti.floor(p), ti.i32)
            block = base >> 3
            if block[0] != at[0] or block[1] != at[1] or block[2] != at[2]:
                at = block
                n = lookup(block[0], block[1], block[2], keys, ids)
            if n < 0:  # go to where the ray leaves this block
                leave = 1e30
                for a in ti.static(range(3)):
                    if ti.abs(d[a]) > 1e-9:
                        side = ti.cast(block[a] * BLOCK, ti.f32)
                        if d[a] > 0.0:
                            side += BLOCK
                        leave = ti.min(leave, (side - origin[a]) / d[a])
                t = ti.max(t, leave) + 0.01 * quantum
                before = -1.0
            else:
                nearest = ti.cast(ti.floor(p + 0.5), ti.i32) - block * BLOCK
                s, w = value(n, nearest[0], nearest[1], nearest[2], neighbours, voxels)
                if w <= 0.0:  # never seen
                    before = -1.0
                    t += 0.5 * quantum
                elif before < 0.0 and s < -1.8 * voxel:  # well inside, and not come from outside
                    t += quantum
                elif s > 1.5 * voxel:  # well outside: a coarse look is enough, and the next one may be just behind
                    before = s
                    t_before = t
                    t += ti.max(0.8 * s / voxel, s / voxel - 0.5) * quantum
                else:
                    local = base & 7
                    f, lowest = corners(n, local[0], local[1], local[2], neighbours, voxels)
                    s = blend(f, p - base)
                    if lowest <= 0.0:
                        before = -1.0
                        t += 0.5 * quantum
                    elif s > 0.0:
                        before = s
                        t_before = t
                        t += (s / voxel + 0.3) * quantum
                    elif before < 0.0:  # inside from the start, or the back of a surface
                        t += quantum
                    else:
                        t0, f0, t1, f1 = t_before, before, t, s
                        known = True
                        for _ in range(4):  # the false position converges fast on a nearly linear field
                            if known and ti.min(f0, -f1) > CLOSE * voxel:
                                m = t0 + (t1 - t0) * ti.min(ti.max(f0 / (f0 - f1), 0.02), 0.98)
                                fm, wm = _field(origin + d * m, keys, ids, neighbours, voxels)
                                known = wm > 0.0
                                if fm > 0.0:
                                    t0, f0 = m, fm
                                else:
                                    t1, f1 = m, fm
                        if known:
                            hit = t0 + (t1 - t0) * f0 / (f0 - f1)
                        else:
                            before = -1.0
                            t += quantum
        nan = ti.math.nan
        g = ti.Vector([nan, nan, nan])
        if hit > 0.0 and hit < end:
            p = origin + d * hit
            base = ti.cast(ti.floor(p), ti.i32)
            n = lookup(base[0] >> 3, base[1] >> 3, base[2] >> 3, keys, ids)
            cell = base & 7
            if n >= 0:
                g = smooth(n, cell, p - base, neighbours, voxels)
                if g.dot(d) >= 0.0:  # unknown, or turned away by what lies behind
                    f, _lowest = corners(n, cell[0], cell[1], cell[2], neighbours, voxels)
                    g = slope(f, p - base)
                g = R.transpose() @ g
                g = g / g.norm()
                if not g.dot(ray) < 0.0:
                    g = ti.Vector([nan, nan, nan])
                if ti.static(colored):
                    near = ti.cast(ti.floor(p + 0.5), ti.i32) - (base - cell)
                    b, o = place(n, near[0], near[1], near[2], neighbours)
                    if b >= 0 and colors[b, o, 3] > 0.0:
                        for a in ti.static(range(3)):
                            image[row, col, a] = ti.cast(colors[b, o, a] / colors[b, o, 3] + 0.5, ti.u8)
        else:
            hit = nan
        depth[row, col] = hit
        for a in ti.static(range(3)):
            points[row, col, a] = ray[a] * hit
            normals[row, col, a] = g[a]
