# mypy: ignore-errors
"""Points, normals and colours where rays end."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32, F32_2, F32_3, I32, U8_3, func, kernel, ti
from fusion.compute.shares import Deal, after, share
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import bounded
from fusion.volume.raycasting.curve import INFINITY, PAD, padded
from fusion.volume.raycasting.image_pool import PIECE
from fusion.volume.raycasting.window import RayField, find
from fusion.volume.sample import corners, place, slope, smooth

SPAN = 1.5  # voxels to either side, at most, over which a normal is taken from the depth image
BEND = 1.0  # voxels that its ends may lie beside the tangent


class Ends(NamedTuple):
    """Depths of the rays and their `slants`, padded and flat, with rows of `wide` pixels; the focal length [px]."""

    x: F32
    y: F32
    depth: F32
    wide: ti.i32
    focal: ti.f32


class Written(NamedTuple):
    """What is filled in, see `PooledImages`; and colours."""

    depth: F32_2
    points: F32
    normals: F32
    used: I32
    rgb: U8_3


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


@func
def _from_field(m: ti.i32, cell: ti.template(), a: ti.template(), d: ti.template(), field: ti.template()):
    """Gradient at a place of a cell of block m, that leads against the ray."""
    f, _lowest = corners(m, cell[0], cell[1], cell[2], field.neighbours, field.voxels)
    g = smooth(m, cell, a, f, field.neighbours, field.voxels)
    if g.dot(d) >= 0.0:  # unknown, or turned away by what lies behind
        g = slope(f, a)
    return g


@kernel
def shade(field: RayField, colors: F32_3, ends: Ends, pose: F32, out: Written, deal: Deal, colored: ti.template()):
    """Fills in depth, points and normals from the depths of the rays, and where it is asked for the colours of pixels
    that see something. Pieces of which `used` says that they are NaN stay so where nothing is seen."""
    x, y, seen, wide, voxel = ti.static((ends.x, ends.y, ends.depth, ends.wide, field.voxel))
    height, width = out.depth.shape[0], out.depth.shape[1]
    across = (width + PIECE - 1) // PIECE
    # In loops of a known length: the others, of which the compiler makes vectors too, take it three times as long.
    total = height * across
    for _ in range(deal.parts):
        n, stop = share(deal.turn, total)
        while n < total:
            v, u0, nearest = n // across, n % across * PIECE, INFINITY
            piece = n
            n, stop = after(n, stop, deal.turn, total)
            begin = bounded((v + PAD) * wide + u0 + PAD)
            for s in range(PIECE):
                nearest = ti.min(nearest, ti.bit_cast(seen[begin + s], ti.i32))
            if nearest == INFINITY and out.used[piece] == 0:
                continue
            out.used[piece] = ti.select(nearest < INFINITY, 1, 0)
            nx, ny, nz = ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE), ti.Vector([0.0] * PIECE)
            span = ti.max(ti.cast(SPAN * voxel * ends.focal / ti.bit_cast(nearest, ti.f32), ti.i32), 1)
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
                        m, cell = find(base >> 3, field), base & 7
                        if m >= 0 and not known:
                            g = R.transpose() @ _from_field(m, cell, p - base, d, field)
                            known = g.dot(ray) < 0.0
                            g /= g.norm()
                        if ti.static(colored):  # noqa: SIM102
                            if m >= 0:
                                near = ti.cast(ti.floor(p + 0.5), ti.i32) - (base - cell)
                                b, o = place(m, near[0], near[1], near[2], field.neighbours)
                                if b >= 0 and colors[b, o, 3] > 0.0:
                                    for a in ti.static(range(3)):
                                        out.rgb[v, u, a] = ti.cast(colors[b, o, a] / colors[b, o, 3] + 0.5, ti.u8)
                    out.depth[v, u] = hit
                    for a in ti.static(range(3)):
                        at = (v * width + u) * 3 + a
                        out.points[at] = ray[a] * hit  # NaN where nothing was hit
                        out.normals[at] = ti.select(known, g[a], ti.math.nan)
