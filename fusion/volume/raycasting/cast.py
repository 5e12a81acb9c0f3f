# mypy: ignore-errors
"""Casting the rays of an image: few are followed from their start, most begin at the plane through those around."""

from typing import NamedTuple

from fusion.compute.language import F32_2, F32_3, I32, func, kernel, ti
from fusion.compute.shares import Deal, after, share
from fusion.volume.lens import Eye
from fusion.volume.raycasting.close import close
from fusion.volume.raycasting.curve import COARSE, PAD, fill
from fusion.volume.raycasting.march import (
    DONE,
    END,
    FAR,
    HIT,
    NUMBERS,
    PIXEL,
    SIDE,
    STATE,
    WHOLES,
    approach,
    begin,
)
from fusion.volume.raycasting.window import TILE, RayField

SPACING = 4.0  # voxels between rays that are done: what fits between them is thinner than the least truncation
APART = 8.0  # voxels by which the depths of rays on one surface differ at most


class Tiles(NamedTuple):
    """Depths between which the rays of tiles may end, see `Window`; tiles that see anything, row << 16 | column, and
    how many."""

    first: F32_2
    last: F32_2
    seeing: I32
    count: ti.i32


class Depths(NamedTuple):
    """Padded images of every ray so far and of twice as many; the depth up to which rays lie SPACING apart [m]."""

    coarse: F32_2
    fine: F32_2
    farthest: ti.f32


@func
def _expected(coarse: ti.template(), v: ti.i32, u: ti.i32, dv: ti.i32, du: ti.i32):
    """Depth on the plane through the pixels that are up to dv, du from (v, u), and how much theirs differ, 0 where one
    of them is missing; and whether one of them is there. Along a line in the image, 1 / z of a plane is linear."""
    a, b = coarse[v, u], coarse[v + dv, u + du]
    c, e = coarse[v, u + du], coarse[v + dv, u]  # the same two unless the ray lies amid four
    z, difference = 0.0, 0.0
    if a > 0.0 and b > 0.0 and c > 0.0 and e > 0.0:
        z = 4.0 / (1.0 / a + 1.0 / b + 1.0 / c + 1.0 / e)
        difference = ti.max(a, b, c, e) - ti.min(a, b, c, e)
    return z, difference, a > 0.0 or b > 0.0 or c > 0.0 or e > 0.0


@func
def _wanted(
    i: ti.i32, j: ti.i32, step: ti.i32, depths: ti.template(), eye: ti.template(), last: ti.f32, voxel: ti.f32
):  # fmt: skip
    """Whether a ray has to be followed, and from which depth, 0 for the start."""
    guess, follow = 0.0, not (depths.fine[i + PAD, j + PAD] > 0.0) and last > 0.0
    if follow and step != COARSE:
        dv, du = i & 1, j & 1
        expected, difference, some = _expected(depths.coarse, (i >> 1) + PAD, (j >> 1) + PAD, dv, du)
        inner = (i + dv) * step < eye.height and (j + du) * step < eye.width
        # the ray was followed before, or lies between such that met nothing
        follow = dv + du > 0 and (some or not inner or last >= depths.farthest)
        if expected < depths.farthest and difference < APART * voxel:
            guess = expected
    return follow, guess


@kernel
def cast(
    step: ti.i32, field: RayField, rays: F32_3, eye: Eye, tiles: Tiles, depths: Depths, deal: Deal,
    distorted: ti.template(),
):  # fmt: skip
    """Fills in the depths of every step-th pixel in both directions; those at twice the step, in `coarse`, are done
    unless the step is COARSE. What such rays enclose is less than SPACING wide up to the farthest depth: there others
    lie on the curve through them or start from them, and where they met nothing, neither do those between them."""
    pose, camera, voxel, count = ti.static((eye.pose, eye.camera, field.voxel, tiles.count))
    down = ti.select(step == 1, 0, ti.select(step == 2, 1, 2))  # as bits: divisions would take as long as the rest
    bits = TILE - down
    rays_of_tile = 1 << (2 * bits)
    for _ in range(deal.parts):
        R = ti.Matrix([[pose[4 * a + b] for b in ti.static(range(3))] for a in ti.static(range(3))])
        origin = ti.Vector([pose[3], pose[7], pose[11]]) / voxel
        ray, whole = ti.Vector([1.0] * NUMBERS), ti.Vector([0] * WHOLES)
        for e in range(SIDE):
            whole[STATE + e] = DONE
        n, stop = share(deal.turn, count)
        m, live, far = 0, ti.select(n < count, 1, 0), 0
        while live > 0:
            live, far = 0, 0
            for e in range(SIDE):
                if whole[STATE + e] == DONE and 0.0 < ray[HIT + e] < ray[END + e]:
                    pixel = whole[PIXEL + e]
                    depths.fine[(pixel >> (16 + down)) + PAD, ((pixel & 0xFFFF) >> down) + PAD] = ray[HIT + e]
                    ray[HIT + e] = -1.0
                while whole[STATE + e] == DONE and n < count:  # the next one takes its place
                    i, j = (tiles.seeing[n] >> 16) << bits, (tiles.seeing[n] & 0xFFFF) << bits
                    if m == 0 and step != COARSE:
                        fill((i >> 1) + PAD, (j >> 1) + PAD, 1 << (bits - 1), depths, voxel)
                    i, j = i | (m >> bits), j | (m & ((1 << bits) - 1))
                    v, u = i << down, j << down
                    m += 1
                    if m == rays_of_tile:
                        m = 0
                        n, stop = after(n, stop, deal.turn, count)
                    if v < eye.height and u < eye.width:
                        near, end = tiles.first[v >> TILE, u >> TILE], tiles.last[v >> TILE, u >> TILE]
                        follow, guess = _wanted(i, j, step, depths, eye, end, voxel)
                        if follow:
                            x, y = (u - camera[2]) / camera[0], (v - camera[3]) / camera[1]
                            if ti.static(distorted):
                                x, y = rays[v, u, 0], rays[v, u, 1]
                            d = R @ ti.Vector([x, y, 1.0]) / voxel
                            begin(ray, whole, e, d, (v << 16) | u, near, end, guess)
                live += ti.select(whole[STATE + e] == DONE, 0, 1)
                far += ti.select(whole[STATE + e] == FAR, 1, 0)
            if 2 * far > live:  # a step takes as long for one as for all
                approach(ray, whole, origin, field)
            elif live > 0:
                close(ray, whole, origin, field)
