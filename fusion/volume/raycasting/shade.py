# mypy: ignore-errors
"""Points, normals and colours where rays end."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.compute.arrays import F32, F32_2, F32_3, I32, I32_2, I64, U8_3
from fusion.compute.language import func, kernel, ti
from fusion.compute.shares import after, share
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import bounded
from fusion.volume.raycasting.curve import INFINITY, PAD, padded
from fusion.volume.raycasting.image_pool import PIECE
from fusion.volume.raycasting.window import find
from fusion.volume.sample import corners, place, slope, smooth

SPAN = 1.5  # voxels to either side, at most, over which a normal is taken from the depth image
BEND = 1.0  # voxels that its ends may lie beside the tangent


@lru_cache(maxsize=4)
def slants(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """x/z and y/z of all pixels, each a flat image with the padding of those of rays."""
    rays = camera.rays()
    x, y = padded(rays[..., 0]).reshape(-1), padded(rays[..., 1]).reshape(-1)
    x.flags.writeable = y.flags.writeable = False
    return x, y


@func
def _across(
    s: ti.i32, at: ti.template(), x: ti.template(), y: ti.template(), depth: ti.template(), most: ti.f32
):  # fmt: skip
    """Unit normal, as three numbers, through the surface points of pixel s from five places on: in the middle, to the
    left and right, above and below; NaN unless they lie as on one smooth surface. Over the same distance as the field's
    gradient it is as exact, and found much faster."""
    o, w, e, n, m = [at[k] + s for k in ti.static(range(5))]
    z, left, right, up, down = depth[o], depth[w], depth[e], depth[n], depth[m]
    flat = (ti.abs(left + right - 2.0 * z) < most) & (ti.abs(up + down - 2.0 * z) < most)  # of NaN it is not true
    ax, bx = x[e] * right - x[w] * left, x[m] * down - x[n] * up
    ay, by = y[e] * right - y[w] * left, y[m] * down - y[n] * up
    az, bz = right - left, down - up
    nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
    towards = nx * x[o] + ny * y[o] + nz < 0.0  # else at a step, a crease or an end
    scale = ti.select(flat & towards, 1.0 / ti.sqrt(nx * nx + ny * ny + nz * nz), ti.math.nan)
    return nx * scale, ny * scale, nz * scale


@kernel
def shade(
    keys: I64, ids: I32, low: I32, size: I32, grid: I32, neighbours: I32_2, voxels: F32, colors: F32_3,
    x: F32, y: F32, seen: F32, wide: ti.i32, pose: F32, voxel: ti.f32, focal: ti.f32, depth: F32_2, points: F32,
    normals: F32, image: U8_3, used: I32, turn: I32, parts: ti.i32, colored: ti.template(),
):  # fmt: skip
    """Fills in depth, points and normals, the latter two flat, from the depths of the rays, and where it is asked for
    the colours of pixels that see something. x, y and `seen` are padded and flat, with rows of `wide` pixels. Pieces of
    which `used` says that they are NaN stay so where nothing is seen."""
    height, width = depth.shape[0], depth.shape[1]
    across = (width + PIECE - 1) // PIECE
    # In loops of a known length: the others, of which the compiler makes vectors too, take it three times as long.
    total = height * across
    for _ in range(parts):
        n, stop = share(turn, total)
        while n < total:
            v, u0, nearest = n // across, n % across * PIECE, INFINITY
            piece = n
            n, stop = after(n, stop, turn, total)
            begin = bounded((v + PAD) * wide + u0 + PAD)
            for s in range(PIECE):
                nearest = ti.min(nearest, ti.bit_cast(seen[begin + s], ti.i32))
            if nearest == INFINITY and used[piece] == 0:
                continue
            used[piece] = ti.select(nearest < INFINITY, 1, 0)
            nx, ny, nz = ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE)
            span = ti.max(ti.cast(SPAN * voxel * focal / ti.bit_cast(nearest, ti.f32), ti.i32), 1)
            inner = nearest < INFINITY and v >= span and v + span < height
            if inner:  # beside the image it reads the next rows
                around = [begin, begin - span, begin + span, begin - span * wide, begin + span * wide]
                places = [bounded(around[k]) for k in ti.static(range(5))]
                for s in range(PIECE):
                    nx[s], ny[s], nz[s] = _across(s, places, x, y, seen, BEND * voxel)
            for s in range(PIECE):
                u = u0 + s
                if u < width:
                    hit = seen[begin + s]
                    g, ray = ti.Vector([nx[s], ny[s], nz[s]]), ti.Vector([x[begin + s], y[begin + s], 1.0])
                    known = inner and g[0] == g[0] and u >= span and u + span < width
                    if hit > 0.0 and (not known or ti.static(colored)):
                        R = ti.Matrix([[pose[4 * a + b] for b in ti.static(range(3))] for a in ti.static(range(3))])
                        d = R @ ray / voxel
                        p = ti.Vector([pose[3], pose[7], pose[11]]) / voxel + d * hit
                        base = ti.cast(ti.floor(p), ti.i32)
                        m, cell = find(base >> 3, low, size, grid, keys, ids), base & 7
                        if m >= 0 and not known:
                            f, _lowest = corners(m, cell[0], cell[1], cell[2], neighbours, voxels)
                            g = smooth(m, cell, p - base, f, neighbours, voxels)
                            if g.dot(d) >= 0.0:  # unknown, or turned away by what lies behind
                                g = slope(f, p - base)
                            g = R.transpose() @ g
                            known = g.dot(ray) < 0.0
                            g /= g.norm()
                        if ti.static(colored):  # noqa: SIM102
                            if m >= 0:
                                near = ti.cast(ti.floor(p + 0.5), ti.i32) - (base - cell)
                                b, o = place(m, near[0], near[1], near[2], neighbours)
                                if b >= 0 and colors[b, o, 3] > 0.0:
                                    for a in ti.static(range(3)):
                                        image[v, u, a] = ti.cast(colors[b, o, a] / colors[b, o, 3] + 0.5, ti.u8)
                    depth[v, u] = hit
                    for a in ti.static(range(3)):
                        at = (v * width + u) * 3 + a
                        points[at] = ray[a] * hit  # NaN where nothing was hit
                        normals[at] = ti.select(known, g[a], ti.math.nan)
