# mypy: ignore-errors
"""Fusing a depth image: each voxel keeps the weighted mean of its distances to the measured surface.

Curless and Levoy 1996, A Volumetric Method for Building Complex Models from Range Images, equations 3 and 4; Newcombe
et al. 2011, KinectFusion, equations 6 to 12. Unlike there, a distance is not the difference of depth along the ray but
that to the plane that touches the surface at the voxel's pixel (point-to-plane, as of Bylow et al. 2013, section
IV-B), times a weight: the cosine at which the surface is seen.
"""

from functools import lru_cache

import numpy as np

from fusion.compute.cards.memory import filled_in, read_only
from fusion.compute.language import F32, F32_2, F32_3, U8_3, func, kernel, ti
from fusion.geometry.pose import inverse
from fusion.plain.blocks import add_missing, measured
from fusion.plain.view import moved, numbers, pixel
from fusion.volume.integration.integrate import Grown, grown
from fusion.volume.integration.planes import EDGE, EDGE_WEIGHT, STEEP
from fusion.volume.lens import lens

# of a pixel: the plane's normal (3) and distance: a point p is in front of it by distance - normal . p [m]; weight;
# and the depth of the plane in the middle of the pixel [m]
DISTANCE, WEIGHT, DEPTH, NUMBERS = 3, 4, 5, 6


def integrate(blocks, images, camera, T_world_camera, frame):
    """Fuse one frame, as `fusion.volume.integration.integrate.integrate`."""
    depth, weight, color = images
    weight = ones(camera) if weight is None else np.ascontiguousarray(weight, np.float32)
    depth = measured(depth, weight, blocks.settings)
    add_missing(blocks, depth, camera, T_world_camera)
    planes, known = filled_in((*camera.shape, NUMBERS), np.float32), lens(camera)
    touch(depth, read_only(weight), camera.rays(), blocks.settings.truncation, planes)
    colored = color is not None and blocks.settings.color
    color = read_only(np.ascontiguousarray(color)) if colored else np.zeros((1, 1, 3), np.uint8)
    update(planes, color, numbers(inverse(T_world_camera), known[:12], known[12]), grown(blocks), colored)


@lru_cache(maxsize=4)
def ones(camera):
    """The weight of all pixels where none is given."""
    weight = np.ones(camera.shape, np.float32)
    weight.flags.writeable = False
    return weight


@func
def near(depth: ti.template(), v: ti.i32, u: ti.i32):
    """One over a pixel's depth, 0 where nothing was measured or outside of the image."""
    i = 0.0
    if 0 <= v < depth.shape[0] and 0 <= u < depth.shape[1] and depth[v, u] > 0:
        i = 1 / depth[v, u]
    return i


@func
def slope(depth: ti.template(), v: ti.i32, u: ti.i32, down: ti.i32, right: ti.i32, truncation: ti.f32):
    """By how much one over the depth grows per pixel along a row or column, from the sides that lie on the same
    surface, and how many do."""
    here, total, sides = near(depth, v, u), 0.0, 0
    for side in ti.static((-1, 1)):
        there = near(depth, v + side * down, u + side * right)
        if ti.abs(1 / there - 1 / here) < truncation:
            total += side * (there - here)
            sides += 1
    return total / ti.max(sides, 1), sides


@func
def step(rays: ti.template(), v: ti.i32, u: ti.i32, down: ti.i32, right: ti.i32):
    """How x/z and y/z change per pixel along a row or column."""
    v0, v1 = ti.max(v - down, 0), ti.min(v + down, rays.shape[0] - 1)
    u0, u1 = ti.max(u - right, 0), ti.min(u + right, rays.shape[1] - 1)
    apart = ti.max(v1 - v0 + u1 - u0, 1)
    return (rays[v1, u1, 0] - rays[v0, u0, 0]) / apart, (rays[v1, u1, 1] - rays[v0, u0, 1]) / apart


@kernel
def touch(depth: F32_2, weight: F32_2, rays: F32_3, truncation: ti.f32, planes: F32_3):
    """The plane at each pixel: of a plane n . p = d, one over the depth is n / d . (x, y, 1), linear in the image."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        i = near(depth, v, u)
        planes[v, u, WEIGHT] = 0.0
        if i > 0:
            whole, du, dv, around = True, 0.0, 0.0, 0.0
            for a, b in ti.static(ti.ndrange((-1, 2), (-1, 2))):
                there = near(depth, v + a, u + b)
                whole &= ti.abs(1 / there - 1 / i) < truncation
                du, dv = du + b * there / 6, dv + a * there / 6  # a straight line through nine, by least squares
                if abs(a) + abs(b) == 1:
                    around += there
            least = STEEP
            if whole:
                i = i / 2 + around / 8
            else:
                du, across = slope(depth, v, u, 0, 1, truncation)
                dv, down = slope(depth, v, u, 1, 0, truncation)
                if across == 0 or down == 0:
                    least = EDGE
            xu, yu = step(rays, v, u, 0, 1)
            xv, yv = step(rays, v, u, 1, 0)
            A, B = (du * yv - dv * yu) / (xu * yv - xv * yu), (dv * xu - du * xv) / (xu * yv - xv * yu)
            n = ti.Vector([A, B, i - A * rays[v, u, 0] - B * rays[v, u, 1]])
            slant = ti.max(i / n.norm(), least)
            for k in ti.static(range(3)):
                planes[v, u, k] = n[k] * slant / i
            planes[v, u, DISTANCE], planes[v, u, DEPTH] = slant / i, 1 / i
            planes[v, u, WEIGHT] = slant * weight[v, u] * ti.select(whole, 1.0, EDGE_WEIGHT)


@kernel
def update(planes: F32_3, color: U8_3, how: F32, blocks: Grown, colored: ti.template()):
    """Adds weight * distance and weight to every voxel that a pixel sees. `how`: pose of the world in the camera (12),
    camera (12), largest (x/z)^2 + (y/z)^2 of its lens."""
    voxels, colors = ti.static((blocks.voxels, blocks.colors))
    for n, o in ti.ndrange(blocks.count, 512):
        at = ti.Vector([o // 64, o // 8 % 8, o % 8])
        p = moved(how, (ti.Vector([blocks.coordinates[n, a] for a in range(3)]) * 8 + at) * blocks.voxel)
        if p[2] > 1e-6 and p[0] ** 2 + p[1] ** 2 < how[24] * p[2] ** 2:
            x, y = pixel(p, how, 12)
            u, v = ti.floor(x + 0.5, ti.i32), ti.floor(y + 0.5, ti.i32)
            if 0 <= u < planes.shape[1] and 0 <= v < planes.shape[0] and planes[v, u, WEIGHT] > 0:
                normal, w = ti.Vector([planes[v, u, k] for k in range(3)]), planes[v, u, WEIGHT]
                distance = ti.min(planes[v, u, DISTANCE] - normal.dot(p), blocks.truncation)
                if p[2] - planes[v, u, DEPTH] < blocks.truncation:  # else hidden behind what was measured
                    place = n * 1024 + o // 8 * 16 + o % 8
                    voxels[place] += w * distance
                    voxels[place + 8] += w
                    if voxels[place] < 0:  # which octants of the block were ever behind a surface
                        ti.atomic_or(blocks.solid[n], 1 << (at[0] // 4 * 4 + at[1] // 4 * 2 + at[2] // 4))
                    if ti.static(colored):  # noqa: SIM102
                        if distance < blocks.truncation:
                            for k in ti.static(range(3)):
                                colors[n, o, k] += w * color[v, u, k]
                            colors[n, o, 3] += w
