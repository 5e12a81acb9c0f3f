# mypy: ignore-errors
"""The slant of the measured surface at every pixel."""

import taichi as ti

from fusion.volume.blocks import F32, F32_2
from fusion.volume.frame import PAD, TILE

STEP = 2  # pixels to either side that the slant of the surface is taken over
STEEP = 0.1  # least slant, about 84 degrees: beyond, depth says nothing about it (guess)
EDGE = 0.5  # slant of pixels without neighbours (guess)


@ti.func
def _eight(image: ti.template(), g: ti.i32):
    """Pixels 8 g to 8 g + 7: written so that the compiler reads them as one vector."""
    return ti.Vector([image[(g << 3) | e] for e in ti.static(range(8))])


@ti.func
def _before(image: ti.template(), g: ti.i32):
    """The pixels STEP to the left of those of group g."""
    a, b = _eight(image, g - 1), _eight(image, g)
    return ti.Vector([a[8 - STEP + e] for e in range(STEP)] + [b[e] for e in range(8 - STEP)])


@ti.func
def _after(image: ti.template(), g: ti.i32):
    """The pixels STEP to the right."""
    a, b = _eight(image, g), _eight(image, g + 1)
    return ti.Vector([a[e + STEP] for e in range(8 - STEP)] + [b[e] for e in range(STEP)])


@ti.func
def _tangent(here: ti.template(), one: ti.template(), other: ti.template(), truncation: ti.f32):
    """Differences of surface points (x/z, y/z, z) after and before; an end that is missing or on another surface gives
    way to the pixel itself."""
    before = (one[2] > 0.0) & (ti.abs(one[2] - here[2]) < truncation)
    after = (other[2] > 0.0) & (ti.abs(other[2] - here[2]) < truncation)
    z0, z1 = ti.select(before, one[2], here[2]), ti.select(after, other[2], here[2])
    x = ti.select(after, other[0], here[0]) * z1 - ti.select(before, one[0], here[0]) * z0
    y = ti.select(after, other[1], here[1]) * z1 - ti.select(before, one[1], here[1]) * z0
    return x, y, z1 - z0


@ti.kernel
def measure_slant(depth: F32, x: F32, y: F32, farthest: F32_2, truncation: ti.f32, slant: F32):
    """Distance to the surface's tangent plane per difference in z, at every pixel with a depth."""
    rows, across = farthest.shape[0] * TILE, depth.shape[0] // (farthest.shape[0] * TILE + 2 * PAD) // 8
    for n in range(rows * across):  # eight pixels at a time
        if n % across < farthest.shape[1] and farthest[n // across // TILE, n % across] > 0.0:
            g = n + PAD * across
            up, down = g - STEP * across, g + STEP * across
            here = (_eight(x, g), _eight(y, g), _eight(depth, g))
            ax, ay, az = _tangent(
                here, (_before(x, g), _before(y, g), _before(depth, g)), (_after(x, g), _after(y, g), _after(depth, g)),
                truncation,
            )  # fmt: skip
            dx, dy, dz = _tangent(
                here, (_eight(x, up), _eight(y, up), _eight(depth, up)),
                (_eight(x, down), _eight(y, down), _eight(depth, down)), truncation,
            )  # fmt: skip
            nx, ny, nz = ay * dz - az * dy, az * dx - ax * dz, ax * dy - ay * dx
            length = ti.sqrt(nx * nx + ny * ny + nz * nz)
            found = ti.abs(nx * here[0] + ny * here[1] + nz) / length
            found = ti.select(found > STEEP, found, STEEP)
            found = ti.select(length > 0.0, found, EDGE)
            known = _eight(slant, g)
            found = ti.select(here[2] > 0.0, found, known)
            for e in ti.static(range(8)):
                slant[(g << 3) | e] = found[e]
