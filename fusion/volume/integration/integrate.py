# mypy: ignore-errors
"""Fusing one depth image: find the blocks it touches, then update every voxel that it sees.

A voxel gets its distance to the plane that touches the measured surface at its pixel, cut off at +truncation (free
space) and left alone where it lies more than the truncation behind the pixel's depth (hidden). With the difference in
depth instead, views from different sides would disagree about the slope of the field, and as grazing ones reach less
far behind the surface, the zero would move. The slant, a cosine, weighs as well: on a curved surface the plane is
right near the measured point only.
"""

from typing import NamedTuple

import numpy as np

from fusion.compute.choice import either
from fusion.compute.language import F32, F32_2, F32_3, I32, I32_2, U8_3, func, kernel, ti
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import eight, high, low
from fusion.geometry.pose import Array, inverse
from fusion.volume.blocks import Blocks
from fusion.volume.integration.allocate import allocate
from fusion.volume.integration.frame import CELL, STRIP, FrameImages, Work
from fusion.volume.integration.planes import Inverse, Planes, Slants, first, measure_planes, second
from fusion.volume.lens import Eye, eye, in_cone, load, moved, project
from fusion.volume.settings import BLOCK

NO_COLOR = np.zeros((1, 1, 3), np.uint8)
NO_WEIGHT = np.ones((1, 1), np.float32)


class Grown(NamedTuple):
    """The blocks that grow by a frame, see `Blocks`; size of a voxel and truncation [m]."""

    coordinates: I32_2
    count: ti.i32
    voxels: F32
    solid: I32
    colors: F32_3
    voxel: ti.f32
    truncation: ti.f32


def grown(blocks: Blocks) -> Grown:
    """As kernels take them."""
    a, settings = blocks.arrays, blocks.settings
    return Grown(a.coordinates, blocks.count, a.flat, a.solid, a.colors, settings.voxel, settings.truncation)


class Shown(NamedTuple):
    """What an image shows: colours; the farthest of each cell, see `Work`; how wide the planes' rows are."""

    color: U8_3
    farthest: F32_2
    stride: ti.i32


@either
def integrate(
    blocks: Blocks,
    images: FrameImages,
    camera: Camera,
    T_world_camera: Array,
    frame: Work,
) -> None:
    """Fuse one frame.

    Args:
        blocks: changed in place.
        camera: with its lens distortion.
        T_world_camera: (4, 4).
        frame: of that camera, nobody else's meanwhile; after an error it cannot be used any more.

    Raises:
        VolumeError: the blocks do not fit into memory; nothing is fused then.
    """
    depth, weight, color = images
    weights = NO_WEIGHT if weight is None else np.ascontiguousarray(weight, np.float32)
    allocate(blocks, (depth, weights), frame, camera, T_world_camera)
    settings, distorted, known = blocks.settings, any(camera.distortion), frame.geometry
    measure_planes(
        Inverse(frame.inverse, frame.weight, frame.filled, known.layout.stride // STRIP),
        Slants(known.x, known.y, known.bend, camera.fx, camera.fy), settings.truncation,
        Planes(frame.level, frame.slopes, frame.scales), distorted, weight is not None,
    )  # fmt: skip
    frame.filled[:] = (frame.filled & 1) * 3
    colored = color is not None and settings.color
    _update(
        grown(blocks), Planes(*frame.shifted),
        Shown(np.ascontiguousarray(color) if colored else NO_COLOR, frame.farthest, known.layout.stride),
        eye(camera, inverse(T_world_camera)), np.empty(blocks.count + 1, np.int32), distorted, colored,
    )  # fmt: skip


@func
def _in_view(centre: ti.template(), extent: ti.template(), truncation: ti.f32, c: ti.template(),
             farthest: ti.template(), height: ti.i32, width: ti.i32, distorted: ti.template()):  # fmt: skip
    """False when the box around a block lies outside of the image or behind all that the image measured there."""
    near, end = centre[2] - extent[2], centre[2] + extent[2]
    radius = extent.norm()
    seen = in_cone(centre, radius, c)
    if seen and near > 0.25 * radius:
        left, right, top, bottom = (
            centre[0] - extent[0], centre[0] + extent[0], centre[1] - extent[1], centre[1] + extent[1],
        )  # fmt: skip
        left, right = left / ti.select(left < 0.0, near, end), right / ti.select(right > 0.0, near, end)
        top, bottom = top / ti.select(top < 0.0, near, end), bottom / ti.select(bottom > 0.0, near, end)
        x, y, du, dv = 0.5 * (left + right), 0.5 * (top + bottom), 0.5 * (right - left), 0.5 * (bottom - top)
        if ti.static(distorted):
            limit, r, spread = ti.sqrt(c[12]), ti.sqrt(x * x + y * y), ti.sqrt(du * du + dv * dv)
            seen = r - spread < limit
            if r > limit:  # draw the centre in to where the lens is known, and the box with it
                spread += r - limit
                x *= limit / r * 0.9999
                y *= limit / r * 0.9999
            du = dv = spread * c[13]
        u, v = project(x, y, c, distorted)
        du, dv = du * c[0], dv * c[1]
        seen = seen and u + du > -1.0 and v + dv > -1.0 and u - du < width and v - dv < height
        if seen:
            v0, u0 = ti.cast(ti.max(v - dv, 0.0), ti.i32) // CELL, ti.cast(ti.max(u - du, 0.0), ti.i32) // CELL
            v1 = ti.cast(ti.min(v + dv + 1.0, height - 1.0), ti.i32) // CELL
            u1 = ti.cast(ti.min(u + du + 1.0, width - 1.0), ti.i32) // CELL
            if (v1 - v0 + 1) * (u1 - u0 + 1) <= 400:
                far = 0.0
                for a in range(v0, v1 + 1):
                    for b in range(u0, u1 + 1):
                        far = high(far, farthest[a, b])
                seen = far > 0.0 and far + truncation > near
    return seen


@func
def _place(at: ti.template(), z: ti.template(), right: ti.template(), down: ti.template(), corner: ti.template(),
           along: ti.template(), across: ti.template(), c: ti.template(), height: ti.i32, width: ti.i32, stride: ti.i32,
           distorted: ti.template()):  # fmt: skip
    """Where the 64 voxels of a slab lie in the images: entry, depth [m], and how far from the pixel's centre [px]."""
    for s in range(BLOCK * BLOCK):
        j, k = float(s >> 3), float(s & 7)
        x, y, deep = [corner[a] + along[a] * j + across[a] * k for a in ti.static(range(3))]
        near = 1.0 / high(deep, 1e-6)
        u, v = project(x * near, y * near, c, distorted)
        # the nearest pixel; what lies outside of the image comes to lie beside its border, where nothing is seen
        un = ti.cast(low(high(ti.select(deep > 1e-6, u, 0.0), 7.5), width + 8.5), ti.i32)
        vn = ti.cast(low(high(v, 0.5), height + 1.5), ti.i32)
        at[s], z[s], right[s], down[s] = vn * stride + un, deep, u - float(un) - 0.5, v - float(vn) - 0.5


@func
def _add_row(
    blocks: ti.template(), n: ti.template(), slab: ti.template(), j: ti.template(), d: ti.template(), w: ti.template()
):
    """Eight distances and weights to row j of a slab of block n, and to its octants what is behind the surface."""
    o = (n << 10) | (slab << 7) | (j << 4)
    sums = ti.Vector([blocks.voxels[o | e] for e in ti.static(range(BLOCK))]) + w * d
    weights = ti.Vector([blocks.voxels[o | (BLOCK + e)] for e in ti.static(range(BLOCK))]) + w
    for e in ti.static(range(BLOCK)):
        blocks.voxels[o | e] = sums[e]
    for e in ti.static(range(BLOCK)):
        blocks.voxels[o | (BLOCK + e)] = weights[e]
    octant = (slab >> 2) << 2 | (j >> 2) << 1
    if (blocks.solid[n] >> octant) & 3 != 3:
        bits = 0
        for e in ti.static(range(BLOCK)):
            bits |= ti.select(sums[e] < 0.0, 1 << (e >> 2), 0)
        if bits != 0:
            ti.atomic_or(blocks.solid[n], bits << octant)


@kernel
def _update(
    blocks: Grown, planes: Planes, image: Shown, eye: Eye, visible: I32, distorted: ti.template(),
    colored: ti.template(),
):  # fmt: skip
    """Fuses the planes; `visible` (blocks + 1,) is to work with: the number of blocks in view, and which these are."""
    coordinates, pose, voxel, truncation = ti.static((blocks.coordinates, eye.pose, blocks.voxel, blocks.truncation))
    visible[0] = 0
    for n in range(blocks.count):
        c = load(eye.camera)
        p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
        centre = moved(pose, p)
        extent = ti.Vector([ti.abs(pose[a * 4]) + ti.abs(pose[a * 4 + 1]) + ti.abs(pose[a * 4 + 2])
                            for a in ti.static(range(3))])  # fmt: skip
        if _in_view(centre, extent * 3.5 * voxel, truncation, c, image.farthest, eye.height, eye.width, distorted):
            visible[ti.atomic_add(visible[0], 1) + 1] = n
    # Half blocks, slab by slab, as the CPU pool never splits below 512 iterations. The compiler makes vectors of loops
    # over 64 numbers that have no branches and write only to arrays of their own, and of eight numbers that are written
    # side by side after all are read. Arrays serve twice, as emptying each takes its time.
    for half in range(visible[0] * 2):
        c = load(eye.camera)
        c[2] += 8.5  # the images begin one pixel up and eight to the left; half a pixel for rounding
        c[3] += 1.5
        n = visible[(half >> 1) + 1]
        p = ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK * voxel
        steps = [ti.Vector([pose[b], pose[4 + b], pose[8 + b]]) * voxel for b in ti.static(range(3))]
        start = moved(pose, p)
        at, down = ti.Vector([0] * 64), ti.Vector([0.0] * 64)
        ws, ds = ti.Vector([0.0] * 64), ti.Vector([0.0] * 64)  # depths, then weights; steps right, then distances
        for slab in range((half & 1) * 4, (half & 1) * 4 + 4):
            corner = start + steps[0] * float(slab)
            _place(at, ws, ds, down, corner, steps[1], steps[2], c, eye.height, eye.width, image.stride, distorted)
            for s in range(BLOCK * BLOCK):
                i, z, slope, scale = planes.level[at[s]], ws[s], planes.slopes[at[s]], planes.scales[at[s]]
                ws[s] = ti.select((z - truncation) * i < 1.0, second(scale), 0.0)  # else hidden
                i += first(slope) * ds[s] + second(slope) * down[s]
                ds[s] = low(first(scale) * (1.0 - z * i), truncation)
            for j in range(BLOCK):
                d, w = eight(ds, j), eight(ws, j)
                some = False
                for e in ti.static(range(BLOCK)):
                    some |= w[e] > 0.0
                if some:
                    _add_row(blocks, n, slab, j, d, w)
            if ti.static(colored):
                for s in range(BLOCK * BLOCK):
                    if ws[s] > 0.0 and ds[s] < truncation:
                        v, u = at[s] // image.stride - 1, at[s] % image.stride - 8
                        for r in ti.static(range(3)):
                            blocks.colors[n, slab * 64 + s, r] += ws[s] * image.color[v, u, r]
                        blocks.colors[n, slab * 64 + s, 3] += ws[s]
