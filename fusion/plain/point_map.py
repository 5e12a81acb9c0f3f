# mypy: ignore-errors
"""A depth image as points with normals.

Points are K^-1 [u, v, 1] z; normals the cross product of differences of points, taken from a smoothed copy of the depth
(Newcombe et al. 2011, KinectFusion, section 3.2, equation 3; the smoothing is a bilateral filter, Tomasi and Manduchi
1998, rows first, then columns, with Tukey's biweight for the difference of depth).
"""

import numpy as np

from fusion.compute.language import F32_2, F32_3, func, kernel, ti
from fusion.compute.start import start

RADIUS = 4  # of the smoothing [px]
WIDTH = RADIUS / 1.5  # standard deviation of its weights [px]
REACH = 2  # of the differences that make a normal, to either side [px]
NEIGHBOURS = 2.0  # steps beyond which a neighbour is on another surface
STEEP = 5.7  # pixel widths by which a surface seen at 80 degrees changes its depth from one pixel to the next


def relief(depth, camera, sigma, step):
    """Points (h, w, 3) [m], unit normals (h, w, 3) towards the camera, and angles (h, w) between normal and line of
    sight [rad]; NaN where they are not known. Arguments as of `fusion.geometry.relief.relief`."""
    start()
    depth = np.ascontiguousarray(depth, np.float32)
    points, normals = np.full((2, *camera.shape, 3), np.nan, np.float32)
    along, smooth, angle = np.full((3, *camera.shape), np.nan, np.float32)
    gain = 1 / (NEIGHBOURS * step)
    average(depth, gain, 0, 1, along)
    average(along, gain, 1, 0, smooth)
    differentiate(depth, smooth, camera.rays(), sigma, STEEP / camera.fx, points, normals, angle)
    return points, normals, angle


@kernel
def average(depth: F32_2, gain: ti.f32, down: ti.i32, right: ti.i32, out: F32_2):
    """The mean of each pixel and its neighbours along a row or a column, those of another depth left out."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        z, total, weights = depth[v, u], 0.0, 0.0
        for k in range(-RADIUS, RADIUS + 1):
            i, j = v + k * down, u + k * right
            if 0 <= i < depth.shape[0] and 0 <= j < depth.shape[1]:
                t = (depth[i, j] - z) * gain
                if ti.abs(t) < 1:  # of NaN it is not true
                    weight = (1 - t * t) ** 2 * ti.exp(-0.5 * (k / WIDTH) ** 2)
                    total += weight * depth[i, j]
                    weights += weight
        if z > 0:
            out[v, u] = total / weights


@func
def point(depth: ti.template(), rays: ti.template(), v: ti.i32, u: ti.i32):
    """What a pixel measured (3,) [m]; NaN outside of the image."""
    z = ti.math.nan
    if 0 <= v < depth.shape[0] and 0 <= u < depth.shape[1]:
        z = depth[v, u]
    i, j = ti.math.clamp(v, 0, depth.shape[0] - 1), ti.math.clamp(u, 0, depth.shape[1] - 1)
    return ti.Vector([rays[i, j, 0] * z, rays[i, j, 1] * z, z])


@kernel
def differentiate(
    depth: F32_2, smooth: F32_2, rays: F32_3, sigma: F32_2, steep: ti.f32, points: F32_3, normals: F32_3, angle: F32_2
):
    """Points, normals and angles; beside holes and steps there is no normal."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        p, z = point(depth, rays, v, u), depth[v, u]
        if z > 0:
            across = point(smooth, rays, v, u + REACH) - point(smooth, rays, v, u - REACH)
            down = point(smooth, rays, v + REACH, u) - point(smooth, rays, v - REACH, u)
            n = down.cross(across).normalized()
            limit, whole = steep * z + 3 * sigma[v, u], True
            for s in ti.static(((0, 1), (0, -1), (1, 0), (-1, 0))):
                whole &= ti.abs(point(depth, rays, v + s[0], u + s[1])[2] - z) < limit
            if not whole:
                n *= ti.math.nan
            for a in ti.static(range(3)):
                points[v, u, a], normals[v, u, a] = p[a], n[a]
            if n[0] == n[0]:
                ray = ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0])
                angle[v, u] = ti.acos(ti.math.clamp(-n.dot(ray.normalized()), 0.0, 1.0))
