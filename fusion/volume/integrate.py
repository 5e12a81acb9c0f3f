"""Fusing one depth image: find the blocks it touches, then update every voxel that it sees.

A voxel at z_voxel in front of the camera whose pixel measured z_measured gets the distance to the plane through the
measured surface there, (z_measured - z_voxel) * slant, cut off at +truncation (free space) and left alone below
-truncation (hidden). Without the slant, views from different sides would disagree about the slope of the field, and
as grazing ones reach less far behind the surface, the zero would move.
"""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64, Blocks, lookup, pack, unpack
from fusion.volume.lens import lens, load, project
from fusion.volume.settings import BLOCK, LATTICE

TILE = 8  # pixels along the edge of a tile, the unit of the first pass
FILTER = 1 << 15  # entries of the table that keeps most doublets out of the list of missing blocks
STEP = 2  # pixels to either side that the slant of the surface is taken over
STEEP = 0.1  # least slant, about 84 degrees: beyond, depth says nothing about it (guess)
EDGE = 0.5  # slant of pixels at an edge (guess)
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
    _slant(clean, camera.rays(), settings.truncation, slant)
    _update(
        blocks.coordinates, blocks.count, blocks.voxels, blocks.colors,
        clean, slant, weights, np.zeros((1, 1, 3), np.uint8) if color is None else np.ascontiguousarray(color),
        farthest, np.empty(blocks.count + 1, np.int32), rows(inverse(T_world_camera)), lens(camera),
        settings.voxel, settings.truncation,
        any(camera.distortion), weight is not None, color is not None and settings.color,
    )  # fmt: skip


def allocate(
    blocks: Blocks, buffers: tuple[NDArray[np.float32], ...], camera: Camera, T_world_camera: Array
) -> NDArray[np.int32]:
    """Add the blocks within the truncation of the measured points; returns those added (n, 3).

    Args:
        blocks: changed in place.
        buffers: depth (h, w), weight (h, w) or (1, 1), then two to be filled: the depth with 0 where missing (h, w)
            and the largest depth of each tile (ceil(h / 8), ceil(w / 8)).
        camera, T_world_camera: as above.

    Raises:
        VolumeError: they do not fit; none is added then.
    """
    settings = blocks.settings
    block = settings.voxel * BLOCK
    box = np.array([-1e30] * 3 + [1e30] * 3 if settings.bounds is None else np.ravel(settings.bounds), np.float32)
    edge = LATTICE - 2  # neighbours stay on the lattice
    span = np.clip(np.floor(box.astype(float) / block), -edge, edge).astype(np.int32)
    seen, missing, size = np.full(FILTER, -1, np.int64), np.zeros(1, np.int32), 1 << 14
    while True:
        keys = np.empty(size, np.int64)
        missing[0] = 0
        _scan(
            *buffers, camera.rays(), rows(T_world_camera), box, span, blocks.keys, blocks.ids, seen, keys, missing,
            settings.voxel, settings.truncation, camera.fx, buffers[1].size > 1 or buffers[0].size == 1,
        )  # fmt: skip
        if missing[0] <= size:
            break
        size, seen = int(missing[0]) * 2, np.full(FILTER, -1, np.int64)
    added = unpack(np.unique(keys[: missing[0]]))
    if len(added):
        blocks.insert(added)
    return added


def rows(T: Array) -> NDArray[np.float32]:
    """The upper three rows of a pose as (12,), the form kernels take."""
    return np.ascontiguousarray(T[:3], np.float32).ravel()


@ti.func
def _touch(
    p: ti.template(), pad: ti.f32, span: ti.template(), keys: ti.template(), ids: ti.template(), seen: ti.template(),
    missing: ti.template(), count: ti.template(), last: ti.i64,
):  # fmt: skip
    """Lists the absent blocks around a point p [blocks]; `last` and the result are the block looked up last."""
    latest = last
    low = ti.floor(p - pad)
    high = ti.floor(p + pad)
    if low.min() > -LATTICE and high.max() < LATTICE:
        a = ti.cast(low, ti.i32)
        b = ti.cast(high, ti.i32)
        for x in range(ti.max(a[0], span[0]), ti.min(b[0], span[3]) + 1):
            for y in range(ti.max(a[1], span[1]), ti.min(b[1], span[4]) + 1):
                for z in range(ti.max(a[2], span[2]), ti.min(b[2], span[5]) + 1):
                    key = pack(x, y, z)
                    if key != latest:
                        latest = key
                        if lookup(x, y, z, keys, ids) < 0:
                            h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
                            if seen[h] != key:
                                seen[h] = key
                                n = ti.atomic_add(count[0], 1)
                                if n < missing.shape[0]:
                                    missing[n] = key
    return latest


@ti.kernel
def _scan(
    depth: F32_2, weight: F32_2, clean: F32_2, farthest: F32_2, rays: F32_3, pose: F32, box: F32, span: I32,
    keys: I64, ids: I32, seen: I64, missing: I64, count: I32,
    voxel: ti.f32, truncation: ti.f32, focal: ti.f32, weighted: ti.template(),
):  # fmt: skip
    height, width = depth.shape[0], depth.shape[1]
    across = farthest.shape[1]
    block = voxel * BLOCK
    reach = ti.min(2.0 * voxel, truncation)  # every sample stands for the cube of this half edge around it
    half = truncation - reach
    samples = ti.cast(ti.ceil(half / reach - 1e-3), ti.i32) + 1
    horizon = block * (LATTICE - 4)
    for tile in range(farthest.shape[0] * across):
        v0 = tile // across * TILE
        u0 = tile % across * TILE
        v1 = ti.min(v0 + TILE, height)
        u1 = ti.min(u0 + TILE, width)
        far = 0.0
        for v in range(v0, v1):
            for u in range(u0, u1):
                z = depth[v, u]
                if not (z > 0.0 and z < horizon):  # also what is NaN
                    z = 0.0
                if ti.static(weighted):
                    w = weight[v, u]
                    if not (w > 0.0 and w < 1e30):
                        z = 0.0
                clean[v, u] = z
                far = ti.max(far, z)
        farthest[tile // across, tile % across] = far
        if far > 0.0:
            R = ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
            t = ti.Vector([pose[3], pose[7], pose[11]])
            stride = ti.max(1, ti.min(TILE, ti.cast(reach * focal / far, ti.i32)))
            last = ti.cast(-1, ti.i64)
            cells = (TILE + stride - 1) // stride
            for cell in range(cells * cells):
                va = v0 + cell // cells * stride
                ua = u0 + cell % cells * stride
                done = -1e30
                for v in range(va, ti.min(va + stride, v1)):
                    for u in range(ua, ti.min(ua + stride, u1)):
                        z = clean[v, u]
                        if z > 0.0 and ti.abs(z - done) > reach:
                            done = z
                            ray = R @ ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0])
                            p = ray * z + t
                            if (
                                p[0] >= box[0] and p[1] >= box[1] and p[2] >= box[2]
                                and p[0] <= box[3] and p[1] <= box[4] and p[2] <= box[5]
                            ):  # fmt: skip
                                for s in range(samples):
                                    shift = 0.0
                                    if samples > 1:
                                        shift = half * (2.0 * s / (samples - 1) - 1.0)
                                    last = _touch(
                                        (p + ray * shift) / block, reach / block, span, keys, ids, seen, missing,
                                        count, last,
                                    )  # fmt: skip


@ti.func
def _tangent(z: ti.f32, v: ti.i32, u: ti.i32, dv: ti.i32, du: ti.i32, depth: ti.template(), rays: ti.template(),
             truncation: ti.f32):  # fmt: skip
    """Difference of the surface points one step (du, dv) after and before a pixel of depth z; 0 at an edge."""
    ends = ti.Matrix([[rays[v, u, 0] * z, rays[v, u, 1] * z, z]] * 2)
    found = 0
    for side in ti.static(range(2)):
        b = v + dv * (2 * side - 1)
        a = u + du * (2 * side - 1)
        if b < 0 or a < 0 or b >= depth.shape[0] or a >= depth.shape[1]:
            b, a = v, u
        d = depth[b, a]
        if d > 0.0 and ti.abs(d - z) < truncation:
            found += 1
            ends[side, 0] = rays[b, a, 0] * d
            ends[side, 1] = rays[b, a, 1] * d
            ends[side, 2] = d
    t = ti.Vector([0.0, 0.0, 0.0])
    if found >= 1:
        t = ti.Vector([ends[1, x] - ends[0, x] for x in ti.static(range(3))])
    return t


@ti.kernel
def _slant(depth: F32_2, rays: F32_3, truncation: ti.f32, slant: F32_2):
    """Distance to the surface's tangent plane per difference in z at every pixel."""
    height, width = depth.shape[0], depth.shape[1]
    for pixel in range(height * width):
        v = pixel // width
        u = pixel % width
        z = depth[v, u]
        if z > 0.0:
            across = _tangent(z, v, u, 0, STEP, depth, rays, truncation)
            down = _tangent(z, v, u, STEP, 0, depth, rays, truncation)
            n = across.cross(down)
            length = n.norm()
            factor = EDGE
            if length > 0.0:
                ray = ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0])
                factor = ti.max(ti.abs(n.dot(ray)) / length, STEEP)
            slant[v, u] = factor


@ti.func
def _in_view(centre: ti.template(), radius: ti.f32, truncation: ti.f32, c: ti.template(), farthest: ti.template(),
             height: ti.i32, width: ti.i32, distorted: ti.template()):  # fmt: skip
    """False when the sphere around a block lies outside of the image or behind all that the image measured there."""
    near = centre[2] - radius
    seen = centre[2] + radius > 0.0
    if near > 0.25 * radius:
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
                u, v = project(x / z, y / z, c, distorted)
                if u > -0.5 and v > -0.5 and u < width - 0.5 and v < height - 0.5:
                    un = ti.cast(u + 0.5, ti.i32)
                    vn = ti.cast(v + 0.5, ti.i32)
                    measured = depth[vn, un]
                    if measured > 0.0:  # the nearest pixel decides whether there is a measurement
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
                        if s > -truncation:
                            o = (i * BLOCK + j) * BLOCK + k
                            voxels[n, o, 0] += w * ti.min(s, truncation)
                            voxels[n, o, 1] += w
                            if ti.static(colored):
                                if s < truncation:
                                    for a in ti.static(range(3)):
                                        colors[n, o, a] += w * ti.cast(color[vn, un, a], ti.f32)
                                    colors[n, o, 3] += w
