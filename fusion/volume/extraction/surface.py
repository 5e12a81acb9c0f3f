# mypy: ignore-errors
"""Marching cubes over the blocks: one vertex per crossed edge, so the mesh is welded from the start."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.choice import either
from fusion.compute.language import F32, F32_2, F32_3, F64_2, I32, I32_2, U8_2, func, kernel, ti
from fusion.mesh.mesh import Mesh
from fusion.volume.blocks import Blocks
from fusion.volume.extraction import cubes
from fusion.volume.extraction.crossings import ROWS, case_of, cells, classify, cross, look, row_of
from fusion.volume.sample import place, value
from fusion.volume.settings import BLOCK


class SurfaceBlocks(NamedTuple):
    """What vertices are made of, see `Blocks`, and the size of a voxel [m]."""

    coordinates: I32_2
    neighbours: I32_2
    voxels: F32
    colors: F32_3
    voxel: ti.f64


class RowEdges(NamedTuple):
    """Of each row of voxels its crossed edges, see `Extracted`, and the number of its first vertex."""

    crossed: I32
    first: I32


class CaseTable(NamedTuple):
    """Triangles of each case and the lowest corner of each edge, see `cubes`."""

    triangles: I32_2
    corner: I32


@dataclass(frozen=True)
class Extracted:
    """A surface and where in the blocks each of its elements comes from; b is the number of blocks."""

    mesh: Mesh  # (n) vertices and (m) faces
    # (b * 64,) of each row of voxels the edges that hold a vertex, a bit each: 8 * axis + place in the row
    crossed: NDArray[np.int32]
    triangles: NDArray[np.int32]  # (b * 64,) how many triangles the cells of each row hold

    def edges(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Of each vertex (n,): block, place of its edge's first voxel in it (0 to 511), axis of the edge; and of each
        face (m,) the block of its cell."""
        rows = np.flatnonzero(self.crossed)
        at, bit = np.nonzero(self.crossed[rows, None] >> np.arange(24) & 1)
        row = rows[at]
        faces = np.repeat(np.arange(len(self.triangles)) // ROWS, self.triangles)
        return row // ROWS, row % ROWS * BLOCK + bit % 8, bit // 8, faces


def surface(blocks: Blocks, min_weight: float) -> Mesh:
    """The zero surface of the blocks.

    Args:
        blocks: the volume's blocks.
        min_weight: cells with a corner of less weight (or none) are left out.

    Returns:
        Vertices [m, world], faces counter-clockwise seen from outside, outward unit normals and, for a volume with
        colour, colours.
    """
    return extract(blocks, min_weight).mesh


@either
def extract(blocks: Blocks, min_weight: float) -> Extracted:
    """The same, with where each vertex and face comes from."""
    n, colored = blocks.count, blocks.settings.color
    rows = n * ROWS
    nothing = Extracted(_empty(colored), np.zeros(rows, np.int32), np.zeros(rows, np.int32))
    if n == 0:
        return nothing
    signs, valid, triangles, crossed, crossings = (np.empty(rows, np.int32) for _ in range(5))
    table = cubes.table().astype(np.int32)
    a = blocks.arrays
    look(a.flat, max(min_weight, 1e-30), n, signs)
    classify(a.neighbours, signs, np.sum(table >= 0, axis=1, dtype=np.int32) // 3, n, valid, triangles)
    cross(a.neighbours, signs, valid, n, crossed, crossings)
    vertex_of, face_of = _starts(crossings), _starts(triangles)
    if face_of[-1] == 0:
        return nothing
    vertices = np.empty((vertex_of[-1], 3))
    normals, colors = np.empty((len(vertices), 3), np.float32), np.empty((len(vertices), 3), np.uint8)
    held = SurfaceBlocks(a.coordinates, a.neighbours, a.flat, a.colors, blocks.settings.voxel)
    crossings_of = RowEdges(crossed, vertex_of)
    _place(held, crossings_of, n, vertices, normals, colors, colored)
    faces = np.empty((face_of[-1], 3), np.int32)
    cases = CaseTable(table, np.array(cubes.EDGES, np.int32)[:, 0].copy())
    _connect(a.neighbours, signs, crossings_of, cases, face_of, n, faces)
    return Extracted(Mesh(vertices, faces, normals, colors if colored else None), crossed, triangles)


def _empty(colored: bool) -> Mesh:
    colors = np.zeros((0, 3), np.uint8) if colored else None
    return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros((0, 3), np.float32), colors)


def _starts(counts: NDArray[np.int32]) -> NDArray[np.int32]:
    """(n + 1,) where each row's items begin, and the total."""
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int32)


@func
def _gradient(n: ti.i32, at: ti.template(), neighbours: ti.template(), voxels: ti.template()):
    """Gradient (3,) at a voxel [m per voxel]: central differences, one-sided beside unseen voxels."""
    g = ti.Vector([0.0, 0.0, 0.0])
    here, _w = value(n, at[0], at[1], at[2], neighbours, voxels)
    for a in ti.static(range(3)):
        step = ti.Vector([a == 0, a == 1, a == 2])
        after, w1 = value(n, at[0] + step[0], at[1] + step[1], at[2] + step[2], neighbours, voxels)
        before, w0 = value(n, at[0] - step[0], at[1] - step[1], at[2] - step[2], neighbours, voxels)
        if w1 <= 0.0:
            after = here
        if w0 <= 0.0:
            before = here
        g[a] = (after - before) / ti.max(1.0, ti.cast(w1 > 0.0, ti.f32) + ti.cast(w0 > 0.0, ti.f32))
    return g


@func
def _number(bits: ti.i32, axis: ti.i32, k: ti.i32):
    """Which of a row's vertices lies on the edge that starts at its k-th voxel along an axis."""
    return ti.math.popcnt(bits & ((1 << (8 * axis + k)) - 1))


@kernel
def _place(
    blocks: SurfaceBlocks, edges: RowEdges, count: ti.i32, vertices: F64_2, normals: F32_2, rgb: U8_2,
    colored: ti.template(),
):  # fmt: skip
    """Vertices, normals and colours."""
    neighbours, voxels, colors = ti.static((blocks.neighbours, blocks.voxels, blocks.colors))
    for row in range(count * ROWS):
        bits = edges.crossed[row]
        if bits != 0:
            n, i, j = row // ROWS, row // BLOCK % BLOCK, row % BLOCK
            for k in range(BLOCK):
                if bits >> k & 0x10101 != 0:
                    o = (i * BLOCK + j) * BLOCK + k
                    f0, _w0 = value(n, i, j, k, neighbours, voxels)
                    here = ti.Vector([i, j, k])
                    g0 = _gradient(n, here, neighbours, voxels)
                    for axis in ti.static(range(3)):
                        if bits >> (8 * axis + k) & 1 == 1:
                            at = edges.first[row] + _number(bits, axis, k)
                            step = ti.Vector([axis == 0, axis == 1, axis == 2])
                            there = here + step
                            f1, _w1 = value(n, there[0], there[1], there[2], neighbours, voxels)
                            # kept off the corners, where several vertices would fall into one
                            a = ti.min(ti.max(f0 / (f0 - f1), 1e-3), 0.999)
                            g = g0 * (1.0 - a) + _gradient(n, there, neighbours, voxels) * a
                            length = g.norm()
                            if length > 0.0:  # noqa: SIM108
                                g = g / length
                            else:
                                g = ti.cast(step, ti.f32) * (1.0 if f1 > f0 else -1.0)
                            for x in ti.static(range(3)):
                                p = ti.cast(blocks.coordinates[n, x] * BLOCK + here[x], ti.f64)
                                vertices[at, x] = (p + ti.cast(a, ti.f64) * step[x]) * blocks.voxel
                                normals[at, x] = g[x]
                            if ti.static(colored):
                                b, q = place(n, there[0], there[1], there[2], neighbours)
                                w0 = colors[n, o, 3] * (1.0 - a)
                                w1 = colors[b, q, 3] * a
                                for x in ti.static(range(3)):
                                    mix = 0.0
                                    if w0 > 0.0:
                                        mix += colors[n, o, x] * (1.0 - a) / (w0 + w1)
                                    if w1 > 0.0:
                                        mix += colors[b, q, x] * a / (w0 + w1)
                                    rgb[at, x] = ti.cast(ti.min(mix + 0.5, 255.0), ti.u8)


@kernel
def _connect(
    neighbours: I32_2, signs: I32, edges: RowEdges, cases: CaseTable, starts: I32, count: ti.i32, faces: I32_2
):
    """Triangles as vertex numbers."""
    for row in range(count * ROWS):
        at = starts[row]
        if starts[row + 1] > at:
            n, i, j = row // ROWS, row // BLOCK % BLOCK, row % BLOCK
            _known, mixed, behind = cells(row, neighbours, signs)
            for k in range(BLOCK):
                if mixed >> k & 1 == 1:
                    case = case_of(behind, k)
                    m = 0
                    while m < cases.triangles.shape[1] and cases.triangles[case, m] >= 0:
                        edge = cases.triangles[case, m]
                        c = cases.corner[edge]
                        other = row_of(n, i + c // 4, j + c // 2 % 2, k + c % 2, neighbours)
                        vertex = edges.first[other] + _number(edges.crossed[other], edge // 4, (k + c % 2) % BLOCK)
                        faces[at + m // 3, 2 - m % 3] = vertex
                        m += 1
                    at += m // 3
