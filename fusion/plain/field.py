# mypy: ignore-errors
"""Reading the volume: the block at a place, a voxel, and the field between eight voxels.

How blocks are stored is told at `fusion.volume.blocks.Blocks`. A distance is a voxel's sum of weight * distance over
its sum of weight; a voxel of no weight was never seen.
"""

from fusion.compute.language import func, ti
from fusion.volume.settings import LATTICE


@func
def key_of(b: ti.template()) -> ti.i64:
    """A block's coordinates (3,) as one number of 63 bits."""
    x, y, z = [ti.cast(b[a] + LATTICE, ti.i64) for a in ti.static(range(3))]
    return (x << 42) | (y << 21) | z


@func
def block_at(b: ti.template(), keys: ti.template(), ids: ti.template()) -> ti.i32:
    """Id of the block at coordinates (3,), -1 where there is none: a hash with places in a row (linear probing).

    Nießner et al. 2013, Real-time 3D Reconstruction at Scale using Voxel Hashing, section 4.1.
    """
    h = (b[0] * 73856093) ^ (b[1] * 19349669) ^ (b[2] * 83492791)
    h, key, found = (h ^ (h >> 13)) & (keys.shape[0] - 1), key_of(b), -1
    while found < 0 and keys[h] != -1:
        if keys[h] == key:
            found = ids[h]
        h = (h + 1) & (keys.shape[0] - 1)
    return found


@func
def place(n: ti.i32, v: ti.template(), neighbours: ti.template()):
    """Block and number in it of voxel (3,) of block n, from -8 to 15 along each axis; block -1 where there is none."""
    block = neighbours[n, (v[0] >> 3) * 9 + (v[1] >> 3) * 3 + (v[2] >> 3) + 13]
    return block, ((v[0] & 7) * 8 + (v[1] & 7)) * 8 + (v[2] & 7)


@func
def voxel(n: ti.i32, v: ti.template(), neighbours: ti.template(), voxels: ti.template()):
    """Distance [m] and weight of that voxel; 0 and 0 where it was never seen."""
    distance, weight = 0.0, 0.0
    block, o = place(n, v, neighbours)
    if block >= 0:
        at = block * 1024 + o // 8 * 16 + o % 8  # rows of eight sums, then their eight weights
        weight = voxels[at + 8]
        if weight > 0:
            distance = voxels[at] / weight
    return distance, weight


@func
def field(p: ti.template(), keys: ti.template(), ids: ti.template(), neighbours: ti.template(), voxels: ti.template()):
    """Distance [m] at a place (3,) [voxels], blended from the eight voxels around; NaN where one was never seen."""
    base = ti.floor(p, ti.i32)
    a, n, distance = p - base, block_at(base >> 3, keys, ids), 0.0
    if n < 0:
        distance = ti.math.nan
    else:
        for o in range(8):
            corner = ti.Vector([o // 4, o // 2 % 2, o % 2])
            d, weight = voxel(n, (base & 7) + corner, neighbours, voxels)
            share = 1.0
            for axis in ti.static(range(3)):
                share *= ti.select(corner[axis] == 1, a[axis], 1 - a[axis])
            distance += ti.select(weight > 0, share * d, ti.math.nan)
    return distance
