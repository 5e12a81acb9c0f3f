# mypy: ignore-errors
"""Which blocks a depth image needs: those with a voxel that a pixel sees within the truncation of what it measured.

Nießner et al. 2013, Real-time 3D Reconstruction at Scale using Voxel Hashing, section 5.1; they follow the ray of each
pixel with a DDA, here it is the box around the piece of the pixel's frustum, so that no voxel beside the ray is missed.
"""

import numpy as np

from fusion.compute.cards.memory import fetch, filled, filled_in
from fusion.compute.language import F32, F32_2, F32_3, I32, I64, kernel, ti
from fusion.plain.field import block_at, key_of
from fusion.plain.view import moved, numbers
from fusion.volume.hashing import Hash
from fusion.volume.integration.missing_blocks import FILTER
from fusion.volume.settings import BLOCK, LATTICE


def allocate(blocks, images, frame, camera, T_world_camera):
    """Add the blocks within the truncation of the measured points, as `fusion.volume.integration.allocate.allocate`."""
    add_missing(blocks, measured(*images, blocks.settings), camera, T_world_camera)


def add_missing(blocks, depth, camera, T_world_camera):
    """The same for a depth image that is `measured`."""
    settings, rays = blocks.settings, camera.rays()
    steps = [np.abs(np.diff(rays, axis=axis)) for axis in range(2)]
    half = 0.5 * max(float(np.max(s[np.isfinite(s)], initial=1 / camera.fx)) for s in steps)
    how = numbers(T_world_camera, settings.voxel, settings.truncation, half)
    missing, count = np.empty(0, np.int64), 1
    while count > len(missing):  # as often as the list was too short
        missing, seen, counted = filled_in(2 * count, np.int64), filled(FILTER, -1, np.int64), np.zeros(1, np.int32)
        look(depth, rays, how, blocks.hash(), seen, missing, counted)
        count = int(counted[0])
    keys = np.unique(fetch(missing)[:count])
    at = np.stack([(keys >> shift & ((1 << 21) - 1)) - LATTICE for shift in (42, 21, 0)], axis=1)
    edge = LATTICE - 2  # neighbours stay on the lattice
    low, high = np.full(3, -edge), np.full(3, edge)
    if settings.bounds is not None:
        low, high = np.clip(np.floor(np.array(settings.bounds) / (settings.voxel * BLOCK)), -edge, edge)
    keys = keys[((at >= low) & (at <= high)).all(axis=1)]
    if len(keys):
        blocks.insert_keys(keys)


def measured(depth, weight, settings):
    """Depth (h, w) [m] without what is none: not finite, not positive, of no weight, or beyond all blocks; 0 there."""
    farthest = settings.voxel * BLOCK * (LATTICE - 4)
    with np.errstate(invalid="ignore"):
        good = (depth > 1e-6) & (depth < farthest)
        if weight.size > 1 or depth.size == 1:
            good &= (weight > 0) & (weight < 1e30)
    depth = np.where(good, depth, np.float32(0))
    depth.flags.writeable = False  # it goes to a card once
    return depth


@kernel
def look(depth: F32_2, rays: F32_3, how: F32, known: Hash, seen: I64, missing: I64, count: I32):
    """Lists blocks that are needed and not there, some of them several times, though `seen` keeps most of that away;
    `count` is how many there would be. `how`: pose of the camera in the world (12), voxel, truncation, half a pixel at
    a depth of 1."""
    for v, u in ti.ndrange(depth.shape[0], depth.shape[1]):
        z, voxel, truncation, half = depth[v, u], how[12], how[13], how[14]
        if z > 0:
            low, high = ti.Vector([1e30, 1e30, 1e30]), ti.Vector([-1e30, -1e30, -1e30])
            for corner in range(8):  # of the frustum's piece
                side = 2 * ti.Vector([corner // 4, corner // 2 % 2, corner % 2]) - 1
                end, aside = z + truncation * side[2], half * (z + truncation)
                x, y = rays[v, u, 0] * end + aside * side[0], rays[v, u, 1] * end + aside * side[1]
                p = moved(how, ti.Vector([x, y, end])) / voxel
                low, high = ti.min(low, p), ti.max(high, p)
            first, last = ti.ceil(low - 0.01, ti.i32) >> 3, ti.floor(high + 0.01, ti.i32) >> 3  # 0.01 for rounding
            for i, j, k in ti.ndrange((first[0], last[0] + 1), (first[1], last[1] + 1), (first[2], last[2] + 1)):
                b = ti.Vector([i, j, k])
                key = key_of(b)
                h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
                if seen[h] != key and block_at(b, known.keys, known.ids) < 0:
                    seen[h] = key
                    n = ti.atomic_add(count[0], 1)
                    if n < missing.shape[0]:
                        missing[n] = key
