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
from fusion.volume.allocate import TILE, allocate
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, Blocks
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
    tiles = (-(-camera.height // TILE), -(-camera.width // TILE))
    clean, slant = np.empty(camera.shape, np.float32), np.empty(camera.shape, np.float32)
    farthest = np.empty(tiles, np.float32)
    weights = np.ones((1, 1), np.float32) if weight is None else np.ascontiguousarray(weight, np.float32)
    allocate(blocks, (depth, weights, clean, farthest), camera, T_world_camera)
    settings = blocks.settings
    measure_slant(clean, camera.rays(), settings.truncation, slant)
    _update(
        blocks.coordinates, blocks.count, blocks.voxels, blocks.colors,
        clean, slant, weights, np.zeros((1, 1, 3), np.uint8) if color is None else np.ascontiguousarray(color),
        farthest, np.empty(blocks.count + 1, np.int32), rows(inverse(T_world_camera)), lens(camera),
        settings.voxel, settings.truncation,
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


@ti.kernel
def _update(
    coordinates: I32_2, count: ti.i32, voxels: F32_3, colors: F32_3, depth: F32_2, slant: F32_2, weight: F32_2,
    color: U8_3, farthest: F32_2, visible: I32, pose: F32, camera: F32, voxel: ti.f32, truncation: ti.f32,
    distorted: ti.template(), weighted: ti.template(), colored: ti.template(),
):  # fmt: skip
    height, width = depth.shape[0], depth.shape[1]
    visible[0] = 0  # the number of blocks in view; their ids follow
    for n in range(count):
        c = load(camera)
        p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
        centre = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                            for a in ti.static(range(3))])  # fmt: skip
        if _in_view(centre, 6.07 * voxel, truncation, c, farthest, height, width, distorted):  # 3.5 * sqrt(3)
            visible[ti.atomic_add(visible[0], 1) + 1] = n
    for row in range(visible[0] * (BLOCK * BLOCK)):  # rows, as the CPU pool never splits below 512 iterations
        c = load(camera)
        n = visible[row // (BLOCK * BLOCK) + 1]
        i = row // BLOCK % BLOCK
        j = row % BLOCK
        p = (
            ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + ti.Vector([i, j, 0])
        ) * voxel
        q = ti.Vector([pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
                       for a in ti.static(range(3))])  # fmt: skip
        step = ti.Vector([pose[2], pose[6], pose[10]]) * voxel
        for k in range(BLOCK):
            x = q[0] + step[0] * k
            y = q[1] + step[1] * k
            z = q[2] + step[2] * k
            if z > 1e-6:
                near = 1.0 / z
                u, v = project(x * near, y * near, c, distorted)
                if u > -0.5 and v > -0.5 and u < width - 0.5 and v < height - 0.5:
                    un = ti.cast(u + 0.5, ti.i32)
                    vn = ti.cast(v + 0.5, ti.i32)
                    measured = depth[vn, un]
                    # the nearest pixel decides whether there is a measurement; interpolation moves it by less than the
                    # truncation, so what lies twice as deep is hidden for certain
                    if measured > 0.0 and measured - z > -2.0 * truncation:
                        w = 1.0
                        if ti.static(weighted):
                            w = weight[vn, un]
                        w *= EDGE_WEIGHT
                        ua = ti.min(ti.cast(ti.max(u, 0.0), ti.i32), width - 2)
                        va = ti.min(ti.cast(ti.max(v, 0.0), ti.i32), height - 2)
                        if ua >= 0 and va >= 0:
                            d00 = depth[va, ua]
                            d01 = depth[va, ua + 1]
                            d10 = depth[va + 1, ua]
                            d11 = depth[va + 1, ua + 1]
                            low = ti.min(ti.min(d00, d01), ti.min(d10, d11))
                            high = ti.max(ti.max(d00, d01), ti.max(d10, d11))
                            if low > 0.0 and high - low < truncation:  # one surface
                                du = ti.min(ti.max(u - ua, 0.0), 1.0)
                                dv = ti.min(ti.max(v - va, 0.0), 1.0)
                                upper = d00 + (d01 - d00) * du
                                lower = d10 + (d11 - d10) * du
                                measured = upper + (lower - upper) * dv
                                w /= EDGE_WEIGHT
                                if ti.static(weighted):
                                    upper = weight[va, ua] + (weight[va, ua + 1] - weight[va, ua]) * du
                                    lower = weight[va + 1, ua] + (weight[va + 1, ua + 1] - weight[va + 1, ua]) * du
                                    w = upper + (lower - upper) * dv
                        s = (measured - z) * slant[vn, un]
                        if measured - z > -truncation:
                            w *= slant[vn, un]
                            o = (i * BLOCK + j) * BLOCK + k
                            voxels[n, o, 0] += w * ti.min(s, truncation)
                            voxels[n, o, 1] += w
                            if ti.static(colored):  # noqa: SIM102
                                if s < truncation:
                                    for a in ti.static(range(3)):
                                        colors[n, o, a] += w * ti.cast(color[vn, un, a], ti.f32)
                                    colors[n, o, 3] += w
