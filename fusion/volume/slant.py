# mypy: ignore-errors
"""The slant of the measured surface at every pixel."""

import taichi as ti

from fusion.volume.blocks import F32_2, F32_3

STEP = 2  # pixels to either side that the slant of the surface is taken over
STEEP = 0.1  # least slant, about 84 degrees: beyond, depth says nothing about it (guess)
EDGE = 0.5  # slant of pixels without neighbours (guess)


@ti.func
def _tangent(z: ti.f32, v: ti.i32, u: ti.i32, dv: ti.i32, du: ti.i32, depth: ti.template(), rays: ti.template(),
             truncation: ti.f32):  # fmt: skip
    """Difference of the surface points one step (du, dv) after and before a pixel of depth z; 0 at an edge."""
    ends = ti.Matrix([[rays[v, u, 0] * z, rays[v, u, 1] * z, z]] * 2)
    found = 0
    for side in ti.static(range(2)):
        b = v + dv * (2 * side - 1)
        a = u + du * (2 * side - 1)
        if b < 0 or a < 0 or b >= rays.shape[0] or a >= rays.shape[1]:
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
def measure_slant(depth: F32_2, rays: F32_3, truncation: ti.f32, slant: F32_2):
    """Distance to the surface's tangent plane per difference in z at every pixel."""
    height, width = rays.shape[0], rays.shape[1]
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
