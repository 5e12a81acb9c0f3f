# mypy: ignore-errors
"""First look at a depth image: drop what is no depth, and give memory to the blocks around what was measured."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.compute.arrays import F32, F32_2, F32_3, I32, I64
from fusion.compute.choice import either
from fusion.compute.language import func, kernel, ti
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import bounded, eight, high, low, put
from fusion.geometry.pose import Array
from fusion.volume.blocks import Blocks
from fusion.volume.integration.frame import CELL, PAD, STRIP, Work, whole
from fusion.volume.integration.missing import FILTER, look
from fusion.volume.lens import rows
from fusion.volume.settings import BLOCK, LATTICE, VolumeSettings

CELLS = STRIP // CELL  # that are looked at side by side
NEAREST = 1e-6  # [m], nothing is measured so close


@either
def allocate(
    blocks: Blocks, images: tuple[NDArray[np.float32], NDArray[np.float32]], frame: Work, camera: Camera,
    T_world_camera: Array,
) -> None:  # fmt: skip
    """Add the blocks within the truncation of the measured points.

    Args:
        blocks: changed in place.
        images: depth (h, w), weight (h, w) or (1, 1).
        frame: its inverse, farthest and what is measured of filled are written to, and its weight where there is any.
        camera, T_world_camera: as above.

    Raises:
        VolumeError: they do not fit; none is added then.
    """
    settings, known = blocks.settings, frame.geometry
    depth, weight = images
    weighted = weight.size > 1 or depth.size == 1
    depth, weight = whole(depth), whole(weight) if weighted else weight
    missing, size = np.zeros(1, np.int32), FILTER
    while True:
        keys, missing[0] = np.empty(size, np.int64), 0
        _scan(
            depth.reshape(-1), depth.shape[1], weight.reshape(-1), frame.inverse, frame.weight, frame.farthest,
            frame.filled, known.cells, known.x, known.y, rows(T_world_camera), _span(settings), blocks.keys, blocks.ids,
            blocks.around, np.full(FILTER, -1, np.int64), keys, missing, settings.voxel, settings.truncation,
            camera.fx, known.margin, settings.voxel * BLOCK * (LATTICE - 4), weighted,
        )  # fmt: skip
        if missing[0] <= size:
            break
        size = int(missing[0]) * 2
    if missing[0] > 0:
        blocks.insert_keys(np.unique(keys[: missing[0]]))


@lru_cache(maxsize=16)
def _span(settings: VolumeSettings) -> NDArray[np.int32]:
    """Lowest and highest block along each axis (6,)."""
    bounds = [-1e30] * 3 + [1e30] * 3 if settings.bounds is None else np.ravel(settings.bounds)
    edge = LATTICE - 2  # neighbours stay on the lattice
    span = np.clip(np.floor(np.array(bounds) / (settings.voxel * BLOCK)), -edge, edge).astype(np.int32)
    span.flags.writeable = False
    return span


@func
def _reach(
    x: ti.template(), y: ti.template(), wide: ti.template(), tall: ti.template(), z0: ti.template(), z1: ti.template(),
    p: ti.template(), voxel: ti.f32,
):  # fmt: skip
    """First and last block along an axis around what lies between two depths behind eight rectangles of pixels."""
    d = p[0] * x + p[1] * y + p[2]
    aside = (ti.abs(p[0]) * wide + ti.abs(p[1]) * tall) * z1
    # blocks that hold a voxel in between; a hundredth for rounding
    first = ti.ceil((p[3] + low(d * z0, d * z1) - aside) / voxel - 0.01, ti.i32) >> 3
    last = ti.floor((p[3] + high(d * z0, d * z1) + aside) / voxel + 0.01, ti.i32) >> 3
    return first, last


@func
def _measured(image: ti.template(), at: ti.i32, width: ti.i32, horizon: ti.f32):
    """Whether a cell high and a strip wide there is a depth in the flat image, from a place on: compared as whole
    numbers, which go up with the depth, and those of NaN lie above."""
    least, most, some = ti.bit_cast(NEAREST, ti.i32), ti.bit_cast(horizon, ti.i32), 0
    for r in range(CELL):
        o = bounded(at + r * width)
        for s in range(STRIP):
            bits = ti.bit_cast(image[o + s], ti.i32)
            some |= ti.select((bits > least) & (bits < most), 1, 0)
    return some == 1


@kernel
def _scan(
    depth: F32, width: ti.i32, weight: F32, inverse: F32, weighed: F32, farthest: F32_2, filled: I32, cells: F32_3,
    x: F32, y: F32, pose: F32, span: I32, keys: I64, ids: I32, around: I32, seen: I64, missing: I64, count: I32,
    voxel: ti.f32, truncation: ti.f32, focal: ti.f32, margin: ti.f32, horizon: ti.f32, weighted: ti.template(),
):  # fmt: skip
    """Fills `inverse`, `farthest` and, where there are weights, `weighed`, and lists absent blocks that hold a voxel
    which a pixel sees within the truncation."""
    across, strips = farthest.shape[1] // CELLS, width // STRIP
    # In loops that have no branches and write to arrays of their own: the compiler makes vectors of them.
    for n in range(farthest.shape[0] * strips):
        row, c0 = n // strips, n % strips * CELLS
        state = row * across + n % strips
        before = filled[state] & 1
        corner = row * CELL * width + c0 * CELL
        if before == 0 and not _measured(depth, corner, width, horizon):
            continue  # it is empty and stays so
        start = (row * CELL + PAD) * across * STRIP + c0 * CELL
        near, far = ti.Vector([0.0] * STRIP), ti.Vector([1e30] * STRIP)  # one over the depths
        for r in range(CELL):
            i, w, at = ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP), bounded(corner + r * width)
            for s in range(STRIP):
                z = depth[at + s]
                known = (z > NEAREST) & (z < horizon)  # NaN is neither
                if ti.static(weighted):
                    w[s] = weight[at + s]
                    known &= (w[s] > 0.0) & (w[s] < 1e30)
                i[s] = ti.select(known, 1.0 / z, 0.0)
                near[s] = high(near[s], i[s])
                far[s] = low(far[s], ti.select(known, i[s], 1e30))
            for g in range(STRIP // 8):
                o = start + r * across * STRIP + g * 8
                put(inverse, o, eight(i, g))
                if ti.static(weighted):
                    put(weighed, o, eight(w, g))
        # Eight cells are looked at side by side, each as one where it is small and all on one surface, then what is
        # left pixel by pixel, eight at a time.
        deep, use, left = ti.Vector([0.0] * CELLS), ti.Vector([0] * CELLS), ti.Vector([0] * CELLS)
        passes, rough = 0, 0
        box = ti.Vector([0.0] * (6 * CELLS))  # what is looked at: x, y, half width, half height, least, largest depth
        for c in range(CELLS):
            a, b = near[c * CELL], far[c * CELL]
            for e in ti.static(range(1, CELL)):
                a, b = high(a, near[c * CELL + e]), low(b, far[c * CELL + e])
            for m in ti.static(range(4)):
                box[m * CELLS + c] = cells[m, row, c0 + c]
            if a > 0.0:
                deep[c], use[c], passes = 1.0 / b, 1, 1
                box[4 * CELLS + c], box[5 * CELLS + c] = 1.0 / a - truncation, 1.0 / b + truncation
                if a - b > 4.0 * voxel * a * b or CELL > 4.0 * voxel * focal * b:  # noqa: SIM300
                    use[c], left[rough] = 0, c
                    rough += 1
        for e in ti.static(range(CELLS)):
            farthest[row, c0 + e] = deep[e]
        filled[state] = (filled[state] & 2) | passes
        begins, ends = ti.Vector([0] * (3 * CELLS)), ti.Vector([0] * (3 * CELLS))
        first, last = ti.Vector([1 << 30, 0, 0]), ti.Vector([0, 0, 0])  # blocks that were all there, or are listed
        for t in range(passes + 2 * rough):
            if t > 0:  # two rows of a cell
                o = start + (t - 1) % 2 * 2 * across * STRIP + left[(t - 1) // 2] * CELL
                at = ti.Vector([o + e // CELL * across * STRIP + e % CELL for e in ti.static(range(CELLS))])
                for e in range(CELLS):
                    box[e], box[CELLS + e], box[2 * CELLS + e], box[3 * CELLS + e] = x[at[e]], y[at[e]], margin, margin
                for e in range(CELLS):
                    i = inverse[at[e]]
                    use[e], z = ti.cast(i > 0.0, ti.i32), 1.0 / high(i, 1e-9)
                    box[4 * CELLS + e], box[5 * CELLS + e] = z - truncation, z + truncation
            h, v, wide, tall, z0, z1 = [eight(box, m) for m in ti.static(range(6))]
            for a in ti.static(range(3)):
                p = ti.Vector([pose[4 * a + m] for m in ti.static(range(4))])
                begin, end = _reach(h, v, wide, tall, z0, z1, p, voxel)
                for e in ti.static(range(CELLS)):
                    begins[a * CELLS + e] = begin[e]
                for e in ti.static(range(CELLS)):
                    ends[a * CELLS + e] = end[e]
            for e in range(CELLS):
                begin = ti.Vector([ti.max(begins[a * CELLS + e], span[a]) for a in ti.static(range(3))])
                end = ti.Vector([ti.min(ends[a * CELLS + e], span[3 + a]) for a in ti.static(range(3))])
                if use[e] == 1 and (end - begin).min() >= 0 and ti.min((begin - first).min(), (last - end).min()) < 0:
                    first, last = begin, end
                    look(begin, end, keys, ids, around, seen, missing, count)
