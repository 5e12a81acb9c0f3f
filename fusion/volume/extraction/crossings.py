# mypy: ignore-errors
"""Where the surface passes between voxels: a row of eight along z is eight bits, so most rows cost a few steps."""

from fusion.compute.language import F32, I32, I32_2, func, kernel, ti
from fusion.geometry.lanes import LANES, eight
from fusion.volume.sample import place
from fusion.volume.settings import BLOCK

ROWS = BLOCK * BLOCK  # of a block


@kernel
def look(voxels: F32, min_weight: ti.f32, count: ti.i32, signs: I32):
    """For each row which voxels lie behind the surface (8 bits) and which are known (the next 8 bits)."""
    for row in range(count * ROWS):
        distance, weight = eight(voxels, 2 * row), eight(voxels, 2 * row + 1)
        bits = 0
        for e in ti.static(range(LANES)):
            bits |= ti.select(distance[e] < 0.0, 1 << e, 0) | ti.select(weight[e] >= min_weight, 256 << e, 0)
        signs[row] = bits


@func
def row_of(n: ti.i32, i: ti.i32, j: ti.i32, k: ti.i32, neighbours: ti.template()):
    """The row that holds voxel (i, j, k) of block n, each of i, j, k from -8 to 15; -1 where there is none."""
    block, o = place(n, i, j, k, neighbours)
    return ti.select(block >= 0, block * ROWS + (o >> 3), -1)


@func
def column(n: ti.i32, i: ti.i32, j: ti.i32, neighbours: ti.template(), signs: ti.template()):
    """Nine voxels from (i, j, 0) of block n upwards: which lie behind the surface, which are known (9 bits each)."""
    here, above = row_of(n, i, j, 0, neighbours), row_of(n, i, j, BLOCK, neighbours)
    bits, top = 0, 0
    if here >= 0:
        bits = signs[here]
    if above >= 0:
        top = signs[above]
    return (bits & 255) | (top & 1) << 8, bits >> 8 | (top & 256)


@func
def cells(row: ti.i32, neighbours: ti.template(), signs: ti.template()):
    """Of the eight cells whose lowest corners are the voxels of a row: which have eight known corners, which of them
    the surface passes through (8 bits each), and which voxels of their four columns lie behind it (9 bits each)."""
    n, i, j = row // ROWS, row // BLOCK % BLOCK, row % BLOCK
    behind = ti.Vector([0, 0, 0, 0])
    known, some, every = 511, 0, 511
    for c in ti.static(range(4)):
        inside, seen = column(n, i + c // 2, j + c % 2, neighbours, signs)
        behind[c] = inside
        known &= seen
        some |= inside
        every &= inside
    valid = known & known >> 1 & 255
    return valid, valid & (some | some >> 1) & ~(every & every >> 1), behind


@func
def case_of(behind: ti.template(), k: ti.i32):
    """The case of the k-th cell above four columns, see `cubes`."""
    case = 0
    for c in ti.static(range(4)):
        case |= (behind[c] >> k & 3) << 2 * c
    return case


@kernel
def classify(neighbours: I32_2, signs: I32, sizes: I32, count: ti.i32, valid: I32, triangles: I32):
    """Which cells of every row have known corners (8 bits), and the number of triangles in the row."""
    for row in range(count * ROWS):
        known, mixed, behind = cells(row, neighbours, signs)
        total = 0
        if mixed != 0:
            for k in range(BLOCK):
                if mixed >> k & 1 == 1:
                    total += sizes[case_of(behind, k)]
        valid[row], triangles[row] = known, total


@func
def _valid(n: ti.i32, i: ti.i32, j: ti.i32, neighbours: ti.template(), valid: ti.template()):
    """Nine cells from (i, j, -1) of block n upwards: which have known corners."""
    here, below = row_of(n, i, j, 0, neighbours), row_of(n, i, j, -1, neighbours)
    bits = 0
    if here >= 0:
        bits = valid[here] << 1
    if below >= 0:
        bits |= valid[below] >> 7
    return bits


@kernel
def cross(neighbours: I32_2, signs: I32, valid: I32, count: ti.i32, crossed: I32, crossings: I32):
    """Which edges that start at a row's voxels carry a vertex (8 bits along x, 8 along y, 8 along z), and how many.

    An edge does whose ends lie on two sides of the surface and that borders on a cell with known corners.
    """
    for row in range(count * ROWS):
        n, i, j = row // ROWS, row // BLOCK % BLOCK, row % BLOCK
        here, _a = column(n, i, j, neighbours, signs)
        along_x, _b = column(n, i + 1, j, neighbours, signs)
        along_y, _c = column(n, i, j + 1, neighbours, signs)
        x, y, z = (here ^ along_x) & 255, (here ^ along_y) & 255, (here ^ here >> 1) & 255
        bits = 0
        if (x | y | z) != 0:
            v00, v01 = _valid(n, i, j, neighbours, valid), _valid(n, i, j - 1, neighbours, valid)
            v10, v11 = _valid(n, i - 1, j, neighbours, valid), _valid(n, i - 1, j - 1, neighbours, valid)
            x &= (v00 | v01) | (v00 | v01) >> 1
            y &= (v00 | v10) | (v00 | v10) >> 1
            z &= (v00 | v01 | v10 | v11) >> 1
            bits = x | y << 8 | z << 16
        crossed[row], crossings[row] = bits, ti.math.popcnt(bits)
