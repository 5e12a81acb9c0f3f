# mypy: ignore-errors
"""First look at a depth image: drop what is no depth, and give memory to the blocks around what was measured."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.choice import either
from fusion.compute.language import F32, F32_2, F32_3, I32, func, kernel, ti
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import bounded, eight, high, low, put
from fusion.geometry.pose import Array
from fusion.volume.blocks import Blocks
from fusion.volume.hashing import Hash
from fusion.volume.integration.frame import CELL, PAD, STRIP, Work, whole
from fusion.volume.integration.missing_blocks import FILTER, MissingBlocks, look
from fusion.volume.lens import rows
from fusion.volume.settings import BLOCK, LATTICE, VolumeSettings

CELLS = STRIP // CELL  # that are looked at side by side
NEAREST = 1e-6  # [m], nothing is measured so close


class RawImages(NamedTuple):
    """Depth and weight as they were measured, flat, in rows of `width` pixels."""

    depth: F32
    weight: F32
    width: ti.i32


class CleanedImages(NamedTuple):
    """What a frame leaves, see `Work`."""

    inverse: F32
    weight: F32
    farthest: F32_2
    filled: I32


class Cells(NamedTuple):
    """What is known of a camera's pixels and cells, see `Geometry`; and its focal length [px]."""

    cells: F32_3
    x: F32
    y: F32
    margin: ti.f32
    focal: ti.f32


class Lattice(NamedTuple):
    """Size of a voxel and truncation [m], lowest and highest block along each axis (6,), depth that may be seen [m]."""

    voxel: ti.f32
    truncation: ti.f32
    span: I32
    horizon: ti.f32


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
    raw = RawImages(depth.reshape(-1), weight.reshape(-1), depth.shape[1])
    cleaned = CleanedImages(frame.inverse, frame.weight, frame.farthest, frame.filled)
    cells = Cells(known.cells, known.x, known.y, known.margin, camera.fx)
    horizon = settings.voxel * BLOCK * (LATTICE - 4)
    lattice = Lattice(settings.voxel, settings.truncation, _span(settings), horizon)
    there, pose, size, count = blocks.hash(), rows(T_world_camera), FILTER, 0
    while True:
        missing = MissingBlocks(np.empty(size, np.int64), np.zeros(1, np.int32), np.full(FILTER, -1, np.int64))
        _scan(raw, cleaned, cells, pose, lattice, there, missing, weighted)
        count = int(missing.count[0])
        if count <= size:
            break
        size = count * 2
    if count > 0:
        blocks.insert_keys(np.unique(missing.keys[:count]))


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


@func
def _invert(
    raw: ti.template(), out: ti.template(), corner: ti.template(), start: ti.template(), across: ti.template(),
    near: ti.template(), far: ti.template(), horizon: ti.template(), weighted: ti.template(),
):  # fmt: skip
    """Fills in one over depth, and weight, of a strip of cells, and the largest and the least of each column."""
    for r in range(CELL):
        i, w, at = ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP), bounded(corner + r * raw.width)
        for s in range(STRIP):
            z = raw.depth[at + s]
            known = (z > NEAREST) & (z < horizon)  # NaN is neither
            if ti.static(weighted):
                w[s] = raw.weight[at + s]
                known &= (w[s] > 0.0) & (w[s] < 1e30)
            i[s] = ti.select(known, 1.0 / z, 0.0)
            near[s] = high(near[s], i[s])
            far[s] = low(far[s], ti.select(known, i[s], 1e30))
        for g in range(STRIP // 8):
            o = start + r * across * STRIP + g * 8
            put(out.inverse, o, eight(i, g))
            if ti.static(weighted):
                put(out.weight, o, eight(w, g))


@func
def _box_pixels(
    box: ti.template(), use: ti.template(), o: ti.template(), across: ti.template(), cells: ti.template(),
    inverse: ti.template(), truncation: ti.template(),
):  # fmt: skip
    """Boxes of the pixels in two rows of a cell, which begins at o, and whether anything is measured there."""
    at = ti.Vector([o + e // CELL * across * STRIP + e % CELL for e in ti.static(range(CELLS))])
    for e in range(CELLS):
        box[e], box[CELLS + e], box[2 * CELLS + e], box[3 * CELLS + e] = (
            cells.x[at[e]], cells.y[at[e]], cells.margin, cells.margin,
        )  # fmt: skip
    for e in range(CELLS):
        i = inverse[at[e]]
        use[e], z = ti.cast(i > 0.0, ti.i32), 1.0 / high(i, 1e-9)
        box[4 * CELLS + e], box[5 * CELLS + e] = z - truncation, z + truncation


@func
def _reaches(box: ti.template(), begins: ti.template(), ends: ti.template(), pose: ti.template(), voxel: ti.template()):
    """First and last block along each axis around what lies in eight boxes."""
    h, v, wide, tall, z0, z1 = [eight(box, m) for m in ti.static(range(6))]
    for a in ti.static(range(3)):
        p = ti.Vector([pose[4 * a + m] for m in ti.static(range(4))])
        begin, end = _reach(h, v, wide, tall, z0, z1, p, voxel)
        for e in ti.static(range(CELLS)):
            begins[a * CELLS + e] = begin[e]
        for e in ti.static(range(CELLS)):
            ends[a * CELLS + e] = end[e]


@kernel
def _scan(
    raw: RawImages, out: CleanedImages, cells: Cells, pose: F32, lattice: Lattice, there: Hash, missing: MissingBlocks,
    weighted: ti.template(),
):  # fmt: skip
    """Cleans a frame, and lists absent blocks that hold a voxel which a pixel sees within the truncation."""
    across, strips = out.farthest.shape[1] // CELLS, raw.width // STRIP
    voxel, truncation, span = ti.static((lattice.voxel, lattice.truncation, lattice.span))
    # In loops that have no branches and write to arrays of their own: the compiler makes vectors of them.
    for n in range(out.farthest.shape[0] * strips):
        row, c0 = n // strips, n % strips * CELLS
        state = row * across + n % strips
        before = out.filled[state] & 1
        corner = row * CELL * raw.width + c0 * CELL
        if before == 0 and not _measured(raw.depth, corner, raw.width, lattice.horizon):
            continue  # it is empty and stays so
        start = (row * CELL + PAD) * across * STRIP + c0 * CELL
        near, far = ti.Vector([0.0] * STRIP), ti.Vector([1e30] * STRIP)  # one over the depths
        _invert(raw, out, corner, start, across, near, far, lattice.horizon, weighted)
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
                box[m * CELLS + c] = cells.cells[m, row, c0 + c]
            if a > 0.0:
                deep[c], use[c], passes = 1.0 / b, 1, 1
                box[4 * CELLS + c], box[5 * CELLS + c] = 1.0 / a - truncation, 1.0 / b + truncation
                if a - b > 4.0 * voxel * a * b or CELL > 4.0 * voxel * cells.focal * b:  # noqa: SIM300
                    use[c], left[rough] = 0, c
                    rough += 1
        for e in ti.static(range(CELLS)):
            out.farthest[row, c0 + e] = deep[e]
        out.filled[state] = (out.filled[state] & 2) | passes
        begins, ends = ti.Vector([0] * (3 * CELLS)), ti.Vector([0] * (3 * CELLS))
        first, last = ti.Vector([1 << 30, 0, 0]), ti.Vector([0, 0, 0])  # blocks that were all there, or are listed
        for t in range(passes + 2 * rough):
            if t > 0:
                o = start + (t - 1) % 2 * 2 * across * STRIP + left[(t - 1) // 2] * CELL
                _box_pixels(box, use, o, across, cells, out.inverse, truncation)
            _reaches(box, begins, ends, pose, voxel)
            for e in range(CELLS):
                begin = ti.Vector([ti.max(begins[a * CELLS + e], span[a]) for a in ti.static(range(3))])
                end = ti.Vector([ti.min(ends[a * CELLS + e], span[3 + a]) for a in ti.static(range(3))])
                if use[e] == 1 and (end - begin).min() >= 0 and ti.min((begin - first).min(), (last - end).min()) < 0:
                    first, last = begin, end
                    look(begin, end, there, missing)
