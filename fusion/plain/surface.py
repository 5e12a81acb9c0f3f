# mypy: ignore-errors
"""The zero surface as triangles: marching cubes (Lorensen and Cline 1987), the case table as `extraction.cubes` has it.

Each cell of eight known voxels has a case, a bit for each corner inside. The case's triangles have their corners on
edges of the cell; an edge is known by the row of voxels that its first voxel lies in, its axis, and its place in the
row. Edges that several triangles use become one vertex.
"""

import numpy as np

from fusion.compute.language import F32, F32_2, F32_3, F64_2, I32, I32_2, I64, I64_2, U8_2, func, kernel, ti
from fusion.mesh.mesh import Mesh
from fusion.plain.field import place, voxel
from fusion.volume.extraction import cubes
from fusion.volume.extraction.surface import Extracted


def extract(blocks, min_weight):
    """The surface and where it comes from, as `fusion.volume.extraction.surface.extract`."""
    colored, n, table = blocks.settings.color, blocks.count, cubes.table().astype(np.int32)
    held = blocks.arrays
    cases = np.zeros(n * 512, np.int32)
    if n:
        classify(held.neighbours, held.flat, max(min_weight, 1e-30), cases)
    sizes = (table >= 0).sum(axis=1) // 3
    triangles = sizes[cases]  # of each cell
    ends = np.cumsum(triangles)
    edges = np.empty((int(ends[-1]) if n else 0, 3), np.int64)
    if len(edges):
        first = np.array(cubes.EDGES, np.int32)[:, 0].copy()
        connect(held.neighbours, cases, (ends - triangles).astype(np.int32), table, first, edges)
    named, faces = np.unique(edges, return_inverse=True)
    vertices, normals = np.empty((len(named), 3)), np.empty((len(named), 3), np.float32)
    colors = np.zeros((len(named), 3), np.uint8)
    if len(named):
        put(named, held.coordinates, held.neighbours, held.flat, vertices, normals)
        vertices *= blocks.settings.voxel
        if colored:
            paint(named, held.neighbours, held.flat, held.colors, colors)
    mesh = Mesh(vertices, faces.reshape(-1, 3).astype(np.int32), normals, colors if colored else None)
    crossed = np.zeros(n * 64, np.int32)
    np.bitwise_or.at(crossed, named // 24, (1 << named % 24).astype(np.int32))
    return Extracted(mesh, crossed, triangles.reshape(-1, 8).sum(axis=1).astype(np.int32))


@func
def corner(cell: ti.i32, o: ti.i32):
    """Block, and voxel (3,) in it, 0 to 8, at the o-th corner of a cell."""
    at = ti.Vector([cell // 64 % 8, cell // 8 % 8, cell % 8])
    return cell // 512, at + ti.Vector([o // 4, o // 2 % 2, o % 2])


@kernel
def classify(neighbours: I32_2, voxels: F32, min_weight: ti.f32, cases: I32):
    """The case of each cell, 0 where a corner weighs less than `min_weight`."""
    for cell in range(cases.shape[0]):
        case, known = 0, True
        for o in range(8):
            n, at = corner(cell, o)
            distance, weight = voxel(n, at, neighbours, voxels)
            known &= weight >= min_weight
            case |= ti.select(distance < 0, 1 << o, 0)
        cases[cell] = ti.select(known, case, 0)


@kernel
def connect(neighbours: I32_2, cases: I32, starts: I32, table: I32_2, first: I32, edges: I64_2):
    """The triangles of each cell as edges. `first`: the lowest corner of each of a cell's twelve edges."""
    for cell in range(cases.shape[0]):
        m = 0
        while m < table.shape[1] and table[cases[cell], m] >= 0:
            edge = table[cases[cell], m]
            n, at = corner(cell, first[edge])
            block, o = place(n, at, neighbours)
            row = ti.cast(block, ti.i64) * 64 + o // 8
            # turned round: what is inside has a distance below 0
            edges[starts[cell] + m // 3, 2 - m % 3] = row * 24 + edge // 4 * 8 + o % 8
            m += 1


@func
def ends(edge: ti.i64):
    """Block, first voxel (3,) and step (3,) to the second one of an edge."""
    row, axis, k = edge // 24, ti.cast(edge % 24 // 8, ti.i32), ti.cast(edge % 8, ti.i32)
    at = ti.Vector([ti.cast(row // 8 % 8, ti.i32), ti.cast(row % 8, ti.i32), k])
    return ti.cast(row // 64, ti.i32), at, ti.Vector([axis == 0, axis == 1, axis == 2])


@func
def crossing(n: ti.i32, at: ti.template(), step: ti.template(), neighbours: ti.template(), voxels: ti.template()):
    """Where on an edge, 0 to 1, the field is zero; kept off its ends, where several vertices would fall into one."""
    f0, _w0 = voxel(n, at, neighbours, voxels)
    f1, _w1 = voxel(n, at + step, neighbours, voxels)
    return ti.math.clamp(f0 / (f0 - f1), 1e-3, 0.999)


@func
def gradient(n: ti.i32, at: ti.template(), neighbours: ti.template(), voxels: ti.template()):
    """Gradient (3,) at a voxel: differences to both sides, to one where the other was never seen."""
    g = ti.Vector([0.0, 0.0, 0.0])
    here, _w = voxel(n, at, neighbours, voxels)
    for a in ti.static(range(3)):
        e, apart = ti.Vector([a == 0, a == 1, a == 2]), 0.0
        for side in ti.static((-1, 1)):
            there, weight = voxel(n, at + side * e, neighbours, voxels)
            if weight > 0:
                g[a] += side * (there - here)
                apart += 1.0
        g[a] /= ti.max(apart, 1.0)
    return g


@kernel
def put(edges: I64, coordinates: I32_2, neighbours: I32_2, voxels: F32, vertices: F64_2, normals: F32_2):
    """Vertex [voxels] and outward normal on each edge."""
    for e in range(edges.shape[0]):
        n, at, step = ends(edges[e])
        a = crossing(n, at, step, neighbours, voxels)
        g = gradient(n, at, neighbours, voxels) * (1 - a) + gradient(n, at + step, neighbours, voxels) * a
        for k in ti.static(range(3)):
            vertices[e, k] = ti.cast(coordinates[n, k] * 8 + at[k], ti.f64) + a * step[k]
            normals[e, k] = g[k] / ti.max(g.norm(), 1e-20)


@kernel
def paint(edges: I64, neighbours: I32_2, voxels: F32, colors: F32_3, rgb: U8_2):
    """The colour on each edge: of both its ends, by weight and nearness."""
    for e in range(edges.shape[0]):
        n, at, step = ends(edges[e])
        a = crossing(n, at, step, neighbours, voxels)
        total, weights = ti.Vector([0.0, 0.0, 0.0]), 0.0
        for side in ti.static(range(2)):
            block, o = place(n, at + side * step, neighbours)
            share = ti.select(side == 1, a, 1 - a)
            total += share * ti.Vector([colors[block, o, k] for k in range(3)])
            weights += share * colors[block, o, 3]
        if weights > 0:
            for k in ti.static(range(3)):
                rgb[e, k] = ti.cast(ti.min(total[k] / weights + 0.5, 255.0), ti.u8)
