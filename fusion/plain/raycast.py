# mypy: ignore-errors
"""The volume as a camera sees it: along each pixel's ray, the first place where the field goes from outside to inside.

Newcombe et al. 2011, KinectFusion, section 3.4, equations 13 and 14: steps along the ray, as long as the field says
that nothing is near; where the sign changes, the place in between; its normal is the field's gradient there.
"""

import numpy as np

from fusion.compute.language import F32, F32_2, F32_3, I32, I32_2, I64, U8_3, func, kernel, ti
from fusion.plain.field import block_at, field, place
from fusion.plain.view import moved, numbers, turned
from fusion.volume.raycasting.raycast import Raycast
from fusion.volume.settings import BLOCK

SHORTEST = 0.5  # step [voxels]
HALVINGS = 12  # of the last step: to a thousandth of a voxel


def raycast(blocks, camera, T_world_camera, reach, images):
    """The surface seen between two depths [m], as `fusion.volume.raycasting.raycast.raycast`; the images stay."""
    voxel, (h, w) = blocks.settings.voxel, camera.shape
    box = np.array([blocks.low, blocks.high + 1]) * BLOCK  # [voxels] nothing lies outside
    T = np.array(T_world_camera)
    T[:3] /= voxel
    how = numbers(T, (max(reach[0], 1e-4), reach[1]), box)
    depth, normals = np.full((h, w), np.nan, np.float32), np.full((h, w, 3), np.nan, np.float32)
    colors = np.zeros((h, w, 3), np.uint8) if blocks.settings.color else None
    if blocks.count:
        held = blocks.arrays
        index = (held.keys, held.ids, held.neighbours)
        follow(camera.rays(), how, *index, held.flat, depth, normals)
        if colors is not None:
            paint(camera.rays(), how, *index, held.colors, depth, colors)
    points = np.dstack([camera.rays() * depth[..., None], depth])
    return Raycast(depth, points, normals, colors)


@func
def between(origin: ti.template(), d: ti.template(), how: ti.template()):
    """Depths between which a ray lies in the box around all blocks."""
    near, far = how[12], how[13]
    for a in ti.static(range(3)):
        if ti.abs(d[a]) > 1e-9:
            one, other = (how[14 + a] - origin[a]) / d[a], (how[17 + a] - origin[a]) / d[a]
            near, far = ti.max(near, ti.min(one, other)), ti.min(far, ti.max(one, other))
        elif origin[a] < how[14 + a] or origin[a] > how[17 + a]:
            far = 0.0
    return near, far


@func
def beyond(p: ti.template(), d: ti.template()):
    """By how much deeper a ray leaves the block that it is in at p."""
    away = 1e30
    for a in ti.static(range(3)):
        if ti.abs(d[a]) > 1e-9:
            side = ti.floor(p[a] / 8) * 8 + ti.select(d[a] > 0, 8.0, 0.0)
            away = ti.min(away, (side - p[a]) / d[a])
    return ti.max(away, 0.0)


@kernel
def follow(rays: F32_3, how: F32, keys: I64, ids: I32, neighbours: I32_2, voxels: F32, depth: F32_2, normals: F32_3):
    """Depth and normal of each pixel that sees something. `how`: pose of the camera in the world [voxels] (12), nearest
    and farthest depth [m], box around all blocks [voxels] (6)."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        ray = ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0])
        d, origin = turned(how, ray), ti.Vector([how[3], how[7], how[11]])  # d: voxels per metre of depth
        t, far = between(origin, d, how)
        one, before, last, hit = 1 / d.norm(), -1.0, 0.0, 0.0  # depth of a voxel's length; no value outside yet
        while t < far and hit == 0:
            p = origin + t * d
            if block_at(ti.floor(p, ti.i32) >> 3, keys, ids) < 0:
                before = -1.0
                t += beyond(p, d) + 0.01 * one + 1e-6 * t
            else:
                now = field(p, keys, ids, neighbours, voxels)
                if before > 0 and now <= 0:
                    low, high = last, t
                    for _ in range(HALVINGS):
                        middle = (low + high) / 2
                        f = field(origin + middle * d, keys, ids, neighbours, voxels)
                        if f > 0:
                            low = middle
                        else:
                            high = middle
                    hit = (low + high) / 2
                before, last = ti.select(now > 0, now, -1.0), t  # of NaN it is not true
                t += SHORTEST * one + 1e-6 * t
        if hit > 0:
            depth[v, u] = hit
            g = gradient(origin + hit * d, keys, ids, neighbours, voxels)
            n = ti.Vector([g.dot(ti.Vector([how[a], how[4 + a], how[8 + a]])) for a in ti.static(range(3))])
            if n.dot(ray) < 0:
                for a in ti.static(range(3)):
                    normals[v, u, a] = n[a] / n.norm()


@func
def gradient(p: ti.template(), keys: ti.template(), ids: ti.template(), neighbours: ti.template(),
             voxels: ti.template()):  # fmt: skip
    """Of the field at a place (3,): differences over a voxel to both sides, to one where the other was never seen."""
    g, here = ti.Vector([0.0, 0.0, 0.0]), field(p, keys, ids, neighbours, voxels)
    for a in ti.static(range(3)):
        e = ti.Vector([a == 0, a == 1, a == 2])
        after = field(p + e, keys, ids, neighbours, voxels)
        before = field(p - e, keys, ids, neighbours, voxels)
        both = after == after and before == before
        one = ti.select(after == after, after - here, here - before)
        g[a] = ti.select(both, (after - before) / 2, one)
    return g


@kernel
def paint(rays: F32_3, how: F32, keys: I64, ids: I32, neighbours: I32_2, colors: F32_3, depth: F32_2, image: U8_3):
    """The colour of the nearest voxel where a pixel sees something."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        if depth[v, u] > 0:
            p = moved(how, ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0]) * depth[v, u])
            at = ti.floor(p + 0.5, ti.i32)
            n = block_at(at >> 3, keys, ids)
            if n >= 0:
                _block, o = place(n, at & 7, neighbours)
                if colors[n, o, 3] > 0:
                    for a in ti.static(range(3)):
                        image[v, u, a] = ti.cast(colors[n, o, a] / colors[n, o, 3] + 0.5, ti.u8)
