# mypy: ignore-errors
"""Where rays have to look: the blocks of a volume as a dense table, and the depths between which each tile of pixels
may meet something solid."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32, F32_2, I32, I32_2, I64, func, kernel, ti
from fusion.compute.shares import Deal, after, dealt, share
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse
from fusion.volume.blocks import Blocks
from fusion.volume.hashing import lookup
from fusion.volume.lens import Eye, eye, in_cone, load, project
from fusion.volume.settings import BLOCK

TILE = 3  # bits of a pixel's place in its tile, which shares one range of depths
LARGEST = 1 << 22  # blocks of a table, 16 MiB


class Boxes(NamedTuple):
    """Where there is what, see `Blocks`, and the size of a voxel [m]."""

    coordinates: I32_2
    count: ti.i32
    solid: I32
    voxel: ti.f32


class BlockTable(NamedTuple):
    """Blocks by their place, see `Window`."""

    low: I32
    size: I32
    grid: I32


class Reach(NamedTuple):
    """Depths between which tiles may see anything, see `Window`, and those between which all that is seen lies [m]."""

    first: F32_2
    last: F32_2
    near: ti.f32
    far: ti.f32


class RayField(NamedTuple):
    """All that rays look up, see `Window` and `Blocks`."""

    low: I32
    size: I32
    grid: I32
    keys: I64
    ids: I32
    solid: I32
    neighbours: I32_2
    voxels: F32
    voxel: ti.f32


@dataclass(frozen=True)
class Window:
    """What rays share."""

    # low, size: (3,) lowest block and number of blocks along each axis; sizes of 0 where blocks lie too far apart
    low: NDArray[np.int32]
    size: NDArray[np.int32]
    grid: NDArray[np.int32]  # flat table of block ids, -1 = none: several times faster than the hash
    # first, last: (tiles down, tiles across) depths between which a tile's rays may end [m]
    first: NDArray[np.float32]
    last: NDArray[np.float32]

    def field(self, blocks: Blocks) -> RayField:
        """What rays look up in the blocks that it is of."""
        a = blocks.arrays
        return RayField(
            self.low, self.size, self.grid, a.keys, a.ids, a.solid, a.neighbours, a.flat, blocks.settings.voxel
        )  # fmt: skip


def window(blocks: Blocks, camera: Camera, T_world_camera: Array, reach: tuple[float, float]) -> Window:
    """For a camera at a pose (4, 4) that looks from near to far [m]."""
    size = blocks.high - blocks.low + 1
    if not blocks.count or np.prod(size.astype(float)) > LARGEST:
        size = np.zeros(3, np.int32)
    grid = np.full(max(int(np.prod(size)), 1), -1, np.int32)
    h, w = camera.shape
    tiles = (-(-h >> TILE), -(-w >> TILE))
    found = Window(blocks.arrays.low, size, grid, np.full(tiles, 1e30, np.float32), np.zeros(tiles, np.float32))
    if blocks.count:
        _range(
            Boxes(blocks.arrays.coordinates, blocks.count, blocks.arrays.solid, blocks.settings.voxel),
            eye(camera, inverse(T_world_camera)), BlockTable(found.low, size, grid),
            Reach(found.first, found.last, *reach), dealt(), any(camera.distortion),
        )  # fmt: skip
    return found


@func
def find(block: ti.template(), field: ti.template()):
    """Id of a block that a ray may end in or come through, -1 when there is none."""
    low, size = ti.static((field.low, field.size))
    n = -1
    if size[0] == 0:
        n = lookup(block[0], block[1], block[2], field.keys, field.ids)
    else:
        x, y, z = block[0] - low[0], block[1] - low[1], block[2] - low[2]
        if x >= 0 and y >= 0 and z >= 0 and x < size[0] and y < size[1] and z < size[2]:
            n = field.grid[(x * size[1] + y) * size[2] + z]
    return n


@func
def _box(
    m: ti.template(), wide: ti.f32, tall: ti.f32, spread: ti.f32, c: ti.template(), height: ti.i32, width: ti.i32,
    distorted: ti.template(),
):  # fmt: skip
    """First and last row and column of the pixels around a point (3,) in front of the camera; none where u1 < 0."""
    x, y, du, dv, outside = m[0] / m[2], m[1] / m[2], wide, tall, False
    if ti.static(distorted):
        limit, r, around = ti.sqrt(c[12]), ti.sqrt(x * x + y * y), spread
        outside = r - spread > limit
        if r > limit:  # draw the centre in to where the lens is known, and the ball with it
            around += r - limit
            x *= limit / r * 0.9999
            y *= limit / r * 0.9999
        du, dv = around * c[13] * c[0], around * c[13] * c[1]
    u, v = project(x, y, c, distorted)
    if outside:
        u = -1e9
    v0, u0 = ti.cast(ti.max(v - dv, 0.0), ti.i32), ti.cast(ti.max(u - du, 0.0), ti.i32)
    v1 = ti.cast(ti.floor(ti.min(v + dv + 1.0, height - 1.0)), ti.i32)
    u1 = ti.cast(ti.floor(ti.min(u + du + 1.0, width - 1.0)), ti.i32)
    return v0, u0, v1, u1


@kernel
def _range(blocks: Boxes, eye: Eye, table: BlockTable, reach: Reach, deal: Deal, distorted: ti.template()):
    """Fills in the table, and the depths of each tile."""
    coordinates, solid, pose, voxel = ti.static((blocks.coordinates, blocks.solid, eye.pose, blocks.voxel))
    first, last, near, far = ti.static((reach.first, reach.last, reach.near, reach.far))
    # A ray ends in a cell with a corner behind the surface: up to one voxel around a solid octant.
    slant = [ti.abs(pose[4 * a]) + ti.abs(pose[4 * a + 1]) + ti.abs(pose[4 * a + 2]) for a in range(3)]
    block, octant = [4.5 * voxel * s for s in slant], [2.5 * voxel * s for s in slant]  # half extents along the axes
    radius = 4.5 * 1.7321 * voxel
    for _ in range(deal.parts):
        begin, stop = share(deal.turn, blocks.count)
        while begin < blocks.count:
            n = begin
            begin, stop = after(begin, stop, deal.turn, blocks.count)
            if table.size[0] > 0:
                cell = ti.Vector([coordinates[n, a] - table.low[a] for a in ti.static(range(3))])
                table.grid[(cell[0] * table.size[1] + cell[1]) * table.size[2] + cell[2]] = n
            if solid[n] == 0:
                continue
            c = load(eye.camera)
            R = ti.Matrix([[pose[4 * a + b] for b in ti.static(range(3))] for a in ti.static(range(3))])
            p = (ti.Vector([coordinates[n, 0], coordinates[n, 1], coordinates[n, 2]]) * BLOCK + 3.5) * voxel
            q = R @ p + ti.Vector([pose[3], pose[7], pose[11]])
            before = q[2] - block[2]
            if q[2] + block[2] > near and before < far and in_cone(q, radius, c):
                regular = before > 0.25 * radius
                wide, tall, spread = 0.0, 0.0, 0.0  # half extents of an octant in the image; the nearest one's for all
                if regular:
                    wide = (octant[0] + (ti.abs(q[0]) + block[0]) / before * octant[2]) / before * c[0]
                    tall = (octant[1] + (ti.abs(q[1]) + block[1]) / before * octant[2]) / before * c[1]
                    aside = ti.sqrt(q[0] * q[0] + q[1] * q[1]) + radius
                    spread = 2.5 * 1.7321 * voxel * (1.0 + aside / before) / before
                for o in range(8):
                    if (solid[n] >> o) & 1 == 1:
                        m = q + R @ (ti.Vector([(o >> 2) & 1, (o >> 1) & 1, o & 1]) * 4.0 - 2.0) * voxel
                        z0, z1 = ti.max(m[2] - octant[2], near), ti.min(m[2] + octant[2], far)
                        v0, u0, v1, u1 = 0, 0, eye.height - 1, eye.width - 1
                        if regular:
                            v0, u0, v1, u1 = _box(m, wide, tall, spread, c, eye.height, eye.width, distorted)
                        if z0 < z1 and v1 >= 0 and u1 >= 0:
                            for a in range(v0 >> TILE, (v1 >> TILE) + 1):
                                for b in range(u0 >> TILE, (u1 >> TILE) + 1):
                                    if z0 < first[a, b]:
                                        ti.atomic_min(first[a, b], z0)
                                    if z1 > last[a, b]:
                                        ti.atomic_max(last[a, b], z1)
