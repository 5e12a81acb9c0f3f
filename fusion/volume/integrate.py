# mypy: ignore-errors
"""Fusing one depth image: find the blocks it touches, then update every voxel that it sees.

A voxel gets its distance to the plane that touches the measured surface at its pixel, cut off at +truncation (free
space) and left alone where it lies more than the truncation behind the pixel's depth (hidden). With the difference in
depth instead, views from different sides would disagree about the slope of the field, and as grazing ones reach less
far behind the surface, the zero would move. The slant, a cosine, weighs as well: on a curved surface the plane is
right near the measured point only.
"""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.lanes import gather, high, low
from fusion.geometry.pose import Array, inverse
from fusion.volume.allocate import allocate
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, Blocks
from fusion.volume.frame import PAD, TILE, VALUES, work
from fusion.volume.lens import in_cone, lens, load, project, rows
from fusion.volume.planes import measure_planes
from fusion.volume.settings import BLOCK

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
    measure_planes(
        frame.inverse, frame.x, frame.y, frame.bend, frame.farthest, camera.fx, camera.fy, settings.truncation,
        frame.weight, frame.planes, frame.filled, any(camera.distortion), weight is not None,
    )  # fmt: skip
    colored = color is not None and settings.color
    skip = ((PAD - 1) * frame.layout.stride - 8) * VALUES  # to the pixel before the first one, up and left
    _update(
        blocks.coordinates, blocks.count, blocks.flat, blocks.solid, blocks.colors,
        *[frame.planes[skip + 8 * n :] for n in range(VALUES)],
        np.ascontiguousarray(color) if colored else np.zeros((1, 1, 3), np.uint8),
        frame.farthest, np.empty(blocks.count + 1, np.int32), rows(inverse(T_world_camera)), lens(camera),
        settings.voxel, settings.truncation, camera.height, camera.width, frame.layout.stride,
        any(camera.distortion), colored,
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


@ti.kernel
def _update(
    coordinates: I32_2, count: ti.i32, voxels: F32, solid: I32, colors: F32_3,
    nx: F32, ny: F32, nz: F32, distance: F32, weight: F32, reach: F32, color: U8_3,
    farthest: F32_2, visible: I32, pose: F32, camera: F32, voxel: ti.f32, truncation: ti.f32,
    height: ti.i32, width: ti.i32, stride: ti.i32, distorted: ti.template(), colored: ti.template(),
):  # fmt: skip
    visible[0] = 0  # the number of blocks in view; their ids follow
    for n in range(count):
        c = load(camera)
        p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
        centre = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                            for a in ti.static(range(3))])  # fmt: skip
        if _in_view(centre, 6.07 * voxel, truncation, c, farthest, height, width, distorted):  # 3.5 * sqrt(3)
            visible[ti.atomic_add(visible[0], 1) + 1] = n
    # Slabs, as the CPU pool never splits below 512 iterations. All eight voxels of a row are computed side by side and
    # without branches, and everything is read before anything is written: so the compiler makes vector instructions.
    for slab in range(visible[0] * BLOCK):
        c = load(camera)
        c[2] += 8.5  # the images begin one pixel up and eight to the left; half a pixel for rounding
        c[3] += 1.5
        n = visible[(slab >> 3) + 1]
        corner = ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK
        p = (corner + ti.Vector([float(slab & 7), 0.0, -0.5])) * voxel
        first = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                           for a in ti.static(range(3))])  # fmt: skip
        along = ti.Vector([pose[1], pose[5], pose[9]]) * voxel
        m = ti.Vector([pose[2], pose[6], pose[10]])
        k = ti.Vector([e + 0.5 for e in range(BLOCK)]) * voxel  # halves: the compiler would treat 0 and 1 apart
        for j in range(BLOCK):
            q = first + along * float(j)
            x, y, z = q[0] + m[0] * k, q[1] + m[1] * k, q[2] + m[2] * k
            near = 1.0 / high(z, 1e-6)
            u, v = project(x * near, y * near, c, distorted)
            # the nearest pixel; what lies outside of the image comes to lie beside its border, where nothing is seen
            un = ti.cast(low(high(u, 7.5), width + 8.5), ti.i32)
            vn = ti.cast(low(high(v, 0.5), height + 1.5), ti.i32)
            at = (vn * stride + un) * VALUES - (un & 7) * (VALUES - 1)
            seen = ti.select(z > 1e-6, gather(reach, at), 0.0) - z
            some = False
            for e in ti.static(range(BLOCK)):
                some |= seen[e] > 0.0
            if some:
                d = low(
                    gather(distance, at) - (gather(nx, at) * x + gather(ny, at) * y + gather(nz, at) * z), truncation
                )
                w = ti.select(seen > 0.0, gather(weight, at), 0.0)
                o = (n << 10) | ((slab & 7) << 7) | (j << 4)
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
                    row = (slab & 7) * BLOCK + j
                    for e in ti.static(range(BLOCK)):
                        if w[e] > 0.0 and d[e] < truncation:
                            for r in ti.static(range(3)):
                                colors[n, row * BLOCK + e, r] += w[e] * color[vn[e] - 1, un[e] - 8, r]
                            colors[n, row * BLOCK + e, 3] += w[e]
