# mypy: ignore-errors
"""Fusing one depth image: find the blocks it touches, then update every voxel that it sees.

A voxel at z_voxel in front of the camera whose pixel measured z_measured gets the distance to the plane through the
measured surface there, (z_measured - z_voxel) * slant, cut off at +truncation (free space) and left alone below
-truncation in z (hidden). Without the slant, views from different sides would disagree about the slope of the field,
and as grazing ones reach less far behind the surface, the zero would move. The slant, a cosine, weighs as well: on a
curved surface the plane is right near the measured point only.
"""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse
from fusion.volume.allocate import allocate
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, Blocks
from fusion.volume.frame import PAD, TILE, work
from fusion.volume.lens import in_cone, lens, load, project, rows
from fusion.volume.settings import BLOCK
from fusion.volume.slant import measure_slant

EDGE_WEIGHT = 0.01  # of pixels beside a jump in depth: they fill in only what no other pixel sees
U8_3 = ti.types.ndarray(ti.u8, 3)


def integrate(
    blocks: Blocks,
    images: tuple[NDArray[np.float32], NDArray[np.float32] | None, NDArray[np.uint8] | None],
    camera: Camera,
    T_world_camera: Array,
) -> None:
    """Fuse one frame.

    Args:
        blocks: changed in place.
        images: depth (h, w) [m], anything not finite and positive is missing; weight (h, w) or None for 1, no
            positive weight is missing too; colour (h, w, 3) or None.
        camera: with its lens distortion.
        T_world_camera: (4, 4).

    Raises:
        VolumeError: the blocks do not fit into memory; nothing is fused then.
    """
    depth, weight, color = images
    weights = np.ones((1, 1), np.float32) if weight is None else np.ascontiguousarray(weight, np.float32)
    frame = work(camera)
    allocate(blocks, (depth, weights), frame, camera, T_world_camera)
    settings = blocks.settings
    measure_slant(frame.depth, frame.x, frame.y, frame.farthest, settings.truncation, frame.slant)
    # the same image from four pixels on: places need to be taken apart once for all four neighbours
    stride = frame.layout.stride
    corners = [frame.depth[shift:] for shift in (0, 1, stride, stride + 1)]
    _update(
        blocks.coordinates, blocks.count, blocks.flat, blocks.solid, blocks.colors,
        *corners, frame.slant, weights.reshape(-1),
        np.zeros((1, 1, 3), np.uint8) if color is None else np.ascontiguousarray(color),
        frame.farthest, np.empty(blocks.count + 1, np.int32), rows(inverse(T_world_camera)), lens(camera),
        settings.voxel, settings.truncation, camera.height, camera.width, stride,
        any(camera.distortion), weight is not None, color is not None and settings.color,
    )  # fmt: skip


@ti.func
def _in_view(centre: ti.template(), radius: ti.f32, truncation: ti.f32, c: ti.template(), farthest: ti.template(),
             height: ti.i32, width: ti.i32, distorted: ti.template()):  # fmt: skip
    """False when the sphere around a block lies outside of the image or behind all that the image measured there."""
    near = centre[2] - radius
    seen = in_cone(centre, radius, c)
    if seen and near > 0.25 * radius:
        x = centre[0] / centre[2]
        y = centre[1] / centre[2]
        r = ti.sqrt(x * x + y * y)
        spread = radius * (1.0 + r) / near
        scale = 1.0
        if ti.static(distorted):
            limit = ti.sqrt(c[12])
            seen = seen and r - spread < limit
            scale = c[13]
            if r > limit:  # draw the centre in to where the lens is known, and the sphere with it
                spread += r - limit
                x *= limit / r * 0.9999
                y *= limit / r * 0.9999
        u, v = project(x, y, c, distorted)
        du = spread * scale * c[0]
        dv = spread * scale * c[1]
        seen = seen and u + du > -1.0 and v + dv > -1.0 and u - du < width and v - dv < height
        if seen:
            v0 = ti.cast(ti.max(v - dv, 0.0), ti.i32) // TILE
            u0 = ti.cast(ti.max(u - du, 0.0), ti.i32) // TILE
            v1 = ti.cast(ti.min(v + dv + 1.0, height - 1.0), ti.i32) // TILE
            u1 = ti.cast(ti.min(u + du + 1.0, width - 1.0), ti.i32) // TILE
            if (v1 - v0 + 1) * (u1 - u0 + 1) <= 400:
                far = 0.0
                for a in range(v0, v1 + 1):
                    for b in range(u0, u1 + 1):
                        far = ti.max(far, farthest[a, b])
                seen = far > 0.0 and far + truncation > near
    return seen


@ti.func
def _low(a: ti.template(), b: ti.template()):
    """The smaller one; unlike ti.min not after a look for NaN, which vectors pay for."""
    return ti.select(a < b, a, b)


@ti.func
def _high(a: ti.template(), b: ti.template()):
    return ti.select(a > b, a, b)


@ti.func
def _read(image: ti.template(), at: ti.template()):
    return ti.Vector([image[at[e]] for e in ti.static(range(BLOCK))])


@ti.kernel
def _update(
    coordinates: I32_2, count: ti.i32, voxels: F32, solid: I32, colors: F32_3,
    depth: F32, depth_right: F32, depth_below: F32, depth_aslant: F32, slant: F32, weight: F32, color: U8_3,
    farthest: F32_2, visible: I32, pose: F32, camera: F32, voxel: ti.f32, truncation: ti.f32,
    height: ti.i32, width: ti.i32, stride: ti.i32,
    distorted: ti.template(), weighted: ti.template(), colored: ti.template(),
):  # fmt: skip
    visible[0] = 0  # the number of blocks in view; their ids follow
    for n in range(count):
        c = load(camera)
        p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
        centre = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                            for a in ti.static(range(3))])  # fmt: skip
        if _in_view(centre, 6.07 * voxel, truncation, c, farthest, height, width, distorted):  # 3.5 * sqrt(3)
            visible[ti.atomic_add(visible[0], 1) + 1] = n
    # Rows, as the CPU pool never splits below 512 iterations. All eight voxels of a row are computed side by side and
    # without branches, and everything is read before anything is written: so the compiler makes vector instructions.
    for row in range(visible[0] * (BLOCK * BLOCK)):
        c = load(camera)
        n = visible[(row >> 6) + 1]
        p = (
            ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK
            + ti.Vector([row >> 3 & 7, row & 7, 0])
        ) * voxel
        q = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                       for a in ti.static(range(3))])  # fmt: skip
        k = ti.Vector([float(e) for e in range(BLOCK)]) * voxel
        z = q[2] + pose[10] * k
        near = 1.0 / _high(z, 1e-6)
        u, v = project((q[0] + pose[2] * k) * near, (q[1] + pose[6] * k) * near, c, distorted)
        right, bottom = ti.cast(width - 1, ti.f32), ti.cast(height - 1, ti.f32)
        uc, vc = _low(_high(u, 0.0), right), _low(_high(v, 0.0), bottom)
        aside = _high(ti.abs(u - uc), ti.abs(v - vc))  # beyond the pixels' centres
        # four pixels around; beyond the last pixel's centre the last two, wholly on the last one's side
        ua, va = ti.cast(_low(uc, right - 0.5), ti.i32), ti.cast(_low(vc, bottom - 0.5), ti.i32)
        du, dv = uc - ti.cast(ua, ti.f32), vc - ti.cast(va, ti.f32)
        at = (va + PAD) * stride + ua
        d00, d01, d10, d11 = _read(depth, at), _read(depth_right, at), _read(depth_below, at), _read(depth_aslant, at)
        upper, lower = d00 + (d01 - d00) * du, d10 + (d11 - d10) * du
        lowest = _low(_low(d00, d01), _low(d10, d11))
        gap = ti.select(lowest > 0.0, _high(_high(d00, d01), _high(d10, d11)) - lowest, truncation)
        # the nearest pixel decides whether there is a measurement
        below, beside = ti.select(dv < 0.5, 0, 1), ti.select(du < 0.5, 0, 1)
        nearest = ti.select(dv < 0.5, ti.select(du < 0.5, d00, d01), ti.select(du < 0.5, d10, d11))
        here = at + below * stride + beside
        flat = _read(slant, here)
        measured = ti.select(gap < truncation, upper + (lower - upper) * dv, nearest)  # one surface, or an edge
        w = ti.select(gap < truncation, flat, flat * EDGE_WEIGHT)
        if ti.static(weighted):
            w *= _read(weight, (va + below) * width + ua + beside)
        w = ti.select(aside < 0.5, w, 0.0)
        w = ti.select(z > 1e-6, w, 0.0)
        w = ti.select(nearest > 0.0, w, 0.0)
        w = ti.select(measured - z > -truncation, w, 0.0)
        d = _low((measured - z) * flat, truncation)
        o = (n << 10) | ((row & 63) << 4)
        sums = ti.Vector([voxels[o | e] for e in ti.static(range(BLOCK))]) + w * d
        weights = ti.Vector([voxels[o | (BLOCK + e)] for e in ti.static(range(BLOCK))]) + w
        for e in ti.static(range(BLOCK)):
            voxels[o | e] = sums[e]
        for e in ti.static(range(BLOCK)):
            voxels[o | (BLOCK + e)] = weights[e]
        if solid[n] == 0:
            for e in ti.static(range(BLOCK)):
                if sums[e] < 0.0:
                    solid[n] = 1
        if ti.static(colored):
            for e in ti.static(range(BLOCK)):
                if w[e] > 0.0 and d[e] < truncation:
                    vn, un = va[e] + below[e], ua[e] + beside[e]
                    for a in ti.static(range(3)):
                        colors[n, (row & 63) * BLOCK + e, a] += w[e] * color[vn, un, a]
                    colors[n, (row & 63) * BLOCK + e, 3] += w[e]
