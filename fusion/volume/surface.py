# mypy: ignore-errors
"""Marching cubes over the blocks: one vertex per crossed edge, so the mesh is welded from the start."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.volume import cubes
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, Blocks, entry
from fusion.volume.sample import place, value
from fusion.volume.settings import BLOCK

U8_2 = ti.types.ndarray(ti.u8, 2)
F64_2 = ti.types.ndarray(ti.f64, 2)


def surface(blocks: Blocks, min_weight: float) -> Mesh:
    """The zero surface of the blocks.

    Args:
        blocks: the volume's blocks.
        min_weight: cells with a corner of less weight (or none) are left out.

    Returns:
        Vertices [m, world], faces counter-clockwise seen from outside, outward unit normals and, for a volume with
        colour, colours.
    """
    n, colored = blocks.count, blocks.settings.color
    if n == 0:
        return _empty(colored)
    cases, index = np.empty((n, BLOCK**3), np.uint8), np.empty((n, BLOCK**3), np.int32)
    triangles, crossings = np.empty(n * BLOCK**2, np.int32), np.empty(n * BLOCK**2, np.int32)  # per row of voxels
    table, used = cubes.table().astype(np.int32), cubes.used()
    _classify(blocks.neighbours, blocks.flat, max(min_weight, 1e-30), table, n, cases, triangles)
    _cross(blocks.neighbours, cases, used, n, index, crossings)
    vertex_of, face_of = _starts(crossings), _starts(triangles)
    if face_of[-1] == 0:
        return _empty(colored)
    vertices = np.empty((vertex_of[-1], 3))
    normals, colors = np.empty((len(vertices), 3), np.float32), np.empty((len(vertices), 3), np.uint8)
    _place(
        blocks.coordinates, blocks.neighbours, blocks.flat, blocks.colors, blocks.settings.voxel, vertex_of, n,
        index, vertices, normals, colors, colored,
    )  # fmt: skip
    faces = np.empty((face_of[-1], 3), np.int32)
    edges = np.array(cubes.EDGES, np.int32)[:, 0].copy()
    _connect(blocks.neighbours, cases, index, table, edges, face_of, n, faces)
    return Mesh(vertices, faces, normals, colors if colored else None)


def _empty(colored: bool) -> Mesh:
    colors = np.zeros((0, 3), np.uint8) if colored else None
    return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros((0, 3), np.float32), colors)


def _starts(counts: NDArray[np.int32]) -> NDArray[np.int32]:
    """(n + 1,) where each row's items begin, and the total."""
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int32)


@ti.kernel
def _classify(
    neighbours: I32_2, voxels: F32, min_weight: ti.f32, table: I32_2, count: ti.i32, cases: U8_2, triangles: I32
):
    """The case of every cell, 0 for cells with an unknown corner, and the number of triangles in every row."""
    for row in range(count * (BLOCK * BLOCK)):
        n = row // (BLOCK * BLOCK)
        i = row // BLOCK % BLOCK
        j = row % BLOCK
        total = 0
        before, known_before = 0, False
        for k in range(BLOCK + 1):
            corners, known = 0, True  # of the four columns at height k; corner 2 c of the cell is column c
            for c in ti.static(range(4)):
                block, o = place(n, i + c // 2, j + c % 2, k, neighbours)
                at = entry(block, o)
                if block < 0 or not voxels[at + BLOCK] >= min_weight:
                    known = False
                elif voxels[at] < 0.0:
                    corners |= 1 << 2 * c
            if k > 0:
                case = 0
                if known and known_before:
                    case = before | (corners << 1)
                cases[n, (i * BLOCK + j) * BLOCK + k - 1] = ti.cast(case, ti.u8)
                if case != 0 and case != 255:
                    m = 0
                    while m < table.shape[1] and table[case, m] >= 0:
                        m += 3
                    total += m // 3
            before, known_before = corners, known
        triangles[row] = total


@ti.kernel
def _cross(neighbours: I32_2, cases: U8_2, used: I32, count: ti.i32, index: I32_2, crossings: I32):
    """Which of the three edges that start at each voxel carry a vertex (bits), and how many there are per row."""
    for row in range(count * (BLOCK * BLOCK)):
        n = row // (BLOCK * BLOCK)
        i = row // BLOCK % BLOCK
        j = row % BLOCK
        total = 0
        for k in range(BLOCK):
            bits = 0
            for o in ti.static(range(7)):  # the cells around that hold one of the three edges: all but (-1, -1, -1)
                di, dj, dk = ti.static(o // 4, o // 2 % 2, o % 2)
                block, c = place(n, i - di, j - dj, k - dk, neighbours)
                if block >= 0:
                    edges = used[ti.cast(cases[block, c], ti.i32)]
                    for axis in ti.static(range(3)):
                        if ti.static(not o & (4 >> axis)):
                            bits |= ((edges >> ti.static(_edge(o, axis))) & 1) << axis
            index[n, (i * BLOCK + j) * BLOCK + k] = bits
            total += (bits & 1) + (bits >> 1 & 1) + (bits >> 2)
        crossings[row] = total


def _edge(corner: int, axis: int) -> int:
    """The cell edge that starts at a corner along an axis."""
    return cubes.EDGES.index((corner, corner | 4 >> axis))


@ti.func
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


@ti.kernel
def _place(
    coordinates: I32_2, neighbours: I32_2, voxels: F32, colors: F32_3, voxel: ti.f64, starts: I32, count: ti.i32,
    index: I32_2, vertices: F64_2, normals: F32_2, rgb: U8_2, colored: ti.template(),
):  # fmt: skip
    """Vertices, normals and colours; turns `index` into 8 * (first vertex of the voxel) + its edge bits."""
    for row in range(count * (BLOCK * BLOCK)):
        at = starts[row]
        if starts[row + 1] > at:
            n = row // (BLOCK * BLOCK)
            i = row // BLOCK % BLOCK
            j = row % BLOCK
            for k in range(BLOCK):
                o = (i * BLOCK + j) * BLOCK + k
                bits = index[n, o]
                index[n, o] = at * 8 + bits
                if bits != 0:
                    f0, _w0 = value(n, i, j, k, neighbours, voxels)
                    here = ti.Vector([i, j, k])
                    g0 = _gradient(n, here, neighbours, voxels)
                    for axis in ti.static(range(3)):
                        if bits >> axis & 1 == 1:
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
                                p = ti.cast(coordinates[n, x] * BLOCK + here[x], ti.f64)
                                vertices[at, x] = (p + ti.cast(a, ti.f64) * step[x]) * voxel
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
                            at += 1


@ti.kernel
def _connect(
    neighbours: I32_2, cases: U8_2, index: I32_2, table: I32_2, corner: I32, starts: I32, count: ti.i32, faces: I32_2
):
    """Triangles as vertex numbers."""
    for row in range(count * (BLOCK * BLOCK)):
        at = starts[row]
        if starts[row + 1] > at:
            n = row // (BLOCK * BLOCK)
            i = row // BLOCK % BLOCK
            j = row % BLOCK
            for k in range(BLOCK):
                case = ti.cast(cases[n, (i * BLOCK + j) * BLOCK + k], ti.i32)
                m = 0
                while m < table.shape[1] and table[case, m] >= 0:
                    edge = table[case, m]
                    c = corner[edge]
                    block, o = place(n, i + c // 4, j + c // 2 % 2, k + c % 2, neighbours)
                    entry = index[block, o]
                    below = entry & ((1 << edge // 4) - 1)  # the voxel's edges along earlier axes
                    faces[at + m // 3, 2 - m % 3] = (entry >> 3) + (below & 1) + (below >> 1)
                    m += 1
                at += m // 3
