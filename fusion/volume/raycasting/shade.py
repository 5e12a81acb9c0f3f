# mypy: ignore-errors
"""Points, normals and colours where rays end."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import ti
from fusion.geometry.camera import Camera
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64
from fusion.volume.raycasting.curve import PAD, padded
from fusion.volume.raycasting.window import find
from fusion.volume.sample import corners, place, slope, smooth

SPAN = 1.5  # voxels to either side over which a normal is taken from the depth image
BEND = 1.0  # voxels that its ends may lie beside the tangent
PIECE = 32  # pixels of a row that are looked at in turn
INFINITY = 0x7F800000  # as bits, which go up with the number; those of NaN lie above

U8_3 = ti.types.ndarray(ti.u8, 3)


@lru_cache(maxsize=4)
def slants(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """x/z and y/z of all pixels, each an image with the padding of those of rays."""
    rays = camera.rays()
    return padded(rays[..., 0]), padded(rays[..., 1])


@ti.func
def _across(v: ti.i32, u: ti.i32, span: ti.i32, x: ti.template(), y: ti.template(), depth: ti.template(), most: ti.f32):
    """Unit normal, as three numbers, through the surface points `span` pixels to all four sides; NaN unless they lie as
    on one smooth surface. Over the same distance as the field's gradient it is as exact, and found much faster."""
    z, left, right = depth[v, u], depth[v, u - span], depth[v, u + span]
    up, down = depth[v - span, u], depth[v + span, u]
    flat = (ti.abs(left + right - 2.0 * z) < most) & (ti.abs(up + down - 2.0 * z) < most)  # of NaN it is not true
    ax, bx = x[v, u + span] * right - x[v, u - span] * left, x[v + span, u] * down - x[v - span, u] * up
    ay, by = y[v, u + span] * right - y[v, u - span] * left, y[v + span, u] * down - y[v - span, u] * up
    az, bz = right - left, down - up
    nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
    towards = nx * x[v, u] + ny * y[v, u] + nz < 0.0  # else at a step, a crease or an end
    scale = ti.select(flat & towards, 1.0 / ti.sqrt(nx * nx + ny * ny + nz * nz), ti.math.nan)
    return nx * scale, ny * scale, nz * scale


@ti.kernel
def shade(
    keys: I64, ids: I32, low: I32, size: I32, grid: I32, neighbours: I32_2, voxels: F32, colors: F32_3,
    x: F32_2, y: F32_2, seen: F32_2, pose: F32, voxel: ti.f32, focal: ti.f32, depth: F32_2, points: F32, normals: F32,
    image: U8_3, blank: ti.i32, colored: ti.template(),
):  # fmt: skip
    """Fills in depth, points and normals, the latter two flat, from the depths of the rays, and where it is asked for
    the colours of pixels that see something. x, y and `seen` are padded; `blank` where all is NaN already."""
    height, width = depth.shape[0], depth.shape[1]
    across = (width + PIECE - 1) // PIECE
    # In loops of a known length: the others, of which the compiler makes vectors too, take it three times as long.
    for piece in range(height * across):
        v, u0, nearest = piece // across, piece % across * PIECE, INFINITY
        for s in range(PIECE):
            bits = ti.bit_cast(seen[v + PAD, u0 + PAD + s], ti.i32)
            nearest = ti.select(bits < nearest, bits, nearest)
        if nearest == INFINITY and blank:
            continue
        nx, ny, nz = ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE)
        span = ti.cast(ti.ceil(SPAN * voxel * focal / ti.bit_cast(nearest, ti.f32)), ti.i32)
        inner = nearest < INFINITY and v >= span and v + span < height
        if inner:  # beside the image it reads the next rows
            for s in range(PIECE):
                nx[s], ny[s], nz[s] = _across(v + PAD, u0 + PAD + s, span, x, y, seen, BEND * voxel)
        for s in range(PIECE):
            u = u0 + s
            if u < width:
                hit = seen[v + PAD, u + PAD]
                g, ray = ti.Vector([nx[s], ny[s], nz[s]]), ti.Vector([x[v + PAD, u + PAD], y[v + PAD, u + PAD], 1.0])
                known = inner and g[0] == g[0] and u >= span and u + span < width
                if hit > 0.0 and (not known or ti.static(colored)):
                    R = ti.Matrix([[pose[4 * a + b] for b in ti.static(range(3))] for a in ti.static(range(3))])
                    d = R @ ray / voxel
                    p = ti.Vector([pose[3], pose[7], pose[11]]) / voxel + d * hit
                    base = ti.cast(ti.floor(p), ti.i32)
                    n, cell = find(base >> 3, low, size, grid, keys, ids), base & 7
                    if n >= 0 and not known:
                        f, _lowest = corners(n, cell[0], cell[1], cell[2], neighbours, voxels)
                        g = smooth(n, cell, p - base, f, neighbours, voxels)
                        if g.dot(d) >= 0.0:  # unknown, or turned away by what lies behind
                            g = slope(f, p - base)
                        g = R.transpose() @ g
                        known = g.dot(ray) < 0.0
                        g /= g.norm()
                    if ti.static(colored):  # noqa: SIM102
                        if n >= 0:
                            near = ti.cast(ti.floor(p + 0.5), ti.i32) - (base - cell)
                            b, o = place(n, near[0], near[1], near[2], neighbours)
                            if b >= 0 and colors[b, o, 3] > 0.0:
                                for a in ti.static(range(3)):
                                    image[v, u, a] = ti.cast(colors[b, o, a] / colors[b, o, 3] + 0.5, ti.u8)
                depth[v, u] = hit
                for a in ti.static(range(3)):
                    at = (v * width + u) * 3 + a
                    points[at] = ray[a] * hit  # NaN where nothing was hit
                    normals[at] = ti.select(known, g[a], ti.math.nan)
