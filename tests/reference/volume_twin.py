"""Slow twins of the volume's kernels: plain loops, double precision, no blocks skipped."""

import itertools

import numpy as np

from fusion.geometry.pose import inverse
from fusion.volume.blocks import by_voxel

BLOCK = 8


def slant_twin(depth, camera, truncation, step=2, steep=0.1, edge=0.5):
    """(h, w) distance to the tangent plane per difference in z."""
    h, w = camera.shape
    points = camera.points(depth).astype(float)
    out = np.zeros((h, w))
    for v, u in itertools.product(range(h), range(w)):
        if not depth[v, u] > 0:
            continue
        tangents = []
        for dv, du in ((0, step), (step, 0)):
            ends = [points[v, u], points[v, u]]
            for side in range(2):
                b, a = v + dv * (2 * side - 1), u + du * (2 * side - 1)
                if 0 <= b < h and 0 <= a < w and abs(depth[b, a] - depth[v, u]) < truncation:
                    ends[side] = points[b, a]
            tangents.append(ends[1] - ends[0])
        n = np.cross(*tangents)
        length = np.linalg.norm(n)
        ray = np.append(camera.rays()[v, u], 1.0)
        out[v, u] = max(abs(n @ ray) / length, steep) if length > 0 else edge
    return out


def integrate_twin(blocks, depth, camera, T, voxel, truncation, edge_weight=0.01):
    """Sums (n, 8, 8, 8, 2) of weight * distance and weight that one frame adds to blocks at coordinates (n, 3)."""
    h, w = camera.shape
    depth = np.where(np.isfinite(depth) & (depth > 0), depth, 0.0)
    slant = slant_twin(np.where(depth > 0, depth, np.nan), camera, truncation)
    out = np.zeros((len(blocks), BLOCK, BLOCK, BLOCK, 2))
    indices = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), -1)
    for n, block in enumerate(blocks):
        points = (block * BLOCK + indices).reshape(-1, 3) * voxel
        local = points @ inverse(T)[:3, :3].T + inverse(T)[:3, 3]
        front = local[:, 2] > 1e-6
        pixels = np.full((len(points), 2), -9.0)
        pixels[front] = camera.project(local[front])
        for q in np.flatnonzero(front):
            u, v = pixels[q]
            if not (-0.5 < u < w - 0.5 and -0.5 < v < h - 0.5):
                continue
            un, vn = int(u + 0.5), int(v + 0.5)
            if depth[vn, un] == 0:
                continue
            measured, weight = depth[vn, un], edge_weight
            ua, va = min(int(max(u, 0)), w - 2), min(int(max(v, 0)), h - 2)
            four = depth[va : va + 2, ua : ua + 2]
            if four.min() > 0 and np.ptp(four) < truncation:
                du, dv = np.clip(u - ua, 0, 1), np.clip(v - va, 0, 1)
                measured, weight = [1 - dv, dv] @ four @ [1 - du, du], 1.0
            s = measured - local[q, 2]
            if s > -truncation:
                weight *= slant[vn, un]
                out[n].reshape(-1, 2)[q] = weight * min(s * slant[vn, un], truncation), weight
    return out


def field_twin(volume):
    """A dense array of distances (x, y, z) [m], NaN where never seen, and the voxel (3,) at its first corner."""
    n = volume.block_count
    coordinates, voxels = volume.blocks.coordinates[:n], by_voxel(volume.blocks.voxels[:n]).astype(float)
    low = coordinates.min(axis=0)
    field = np.full((coordinates.max(axis=0) - low + 1) * BLOCK, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        distance = np.where(voxels[..., 1] > 0, voxels[..., 0] / voxels[..., 1], np.nan)
    for at, block in zip((coordinates - low) * BLOCK, distance, strict=True):
        field[tuple(slice(a, a + BLOCK) for a in at)] = block.reshape(BLOCK, BLOCK, BLOCK)
    return field, low * BLOCK


def trilinear_twin(field, p):
    """Value of a dense field at p [voxels from its first corner], NaN outside and beside unseen voxels."""
    base = np.floor(p).astype(int)
    if (base < 0).any() or (base + 1 >= field.shape).any():
        return np.nan
    a, total = p - base, 0.0
    for corner in itertools.product((0, 1), repeat=3):
        total += field[tuple(base + corner)] * np.prod(np.where(corner, a, 1 - a))
    return total


def raycast_twin(volume, camera, T, pixel, reach=(0.1, 10.0)):
    """Depth of one pixel (v, u): tiny steps to the first crossing from outside to inside, then bisection."""
    field, low = field_twin(volume)
    voxel = volume.settings.voxel
    d = T[:3, :3] @ np.append(camera.rays()[pixel], 1.0).astype(float) / voxel
    o = T[:3, 3] / voxel - low
    before, step = np.nan, 0.1 / np.linalg.norm(d)
    for t in np.arange(*reach, step):
        now = trilinear_twin(field, o + d * t)
        if before > 0 and now <= 0:
            a, b = t - step, t
            for _ in range(30):
                m = (a + b) / 2
                a, b = (m, b) if trilinear_twin(field, o + d * m) > 0 else (a, m)
            return (a + b) / 2
        before = now
    return np.nan


def crossings_twin(volume):
    """Surface vertices (n, 3) [m]: a crossing on every edge that belongs to a cell whose corners were all seen."""
    field, low = field_twin(volume)
    known = np.isfinite(field)
    cells = np.lib.stride_tricks.sliding_window_view(known, (2, 2, 2)).all(axis=(3, 4, 5))
    vertices = []
    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        for at in np.argwhere(known):
            there = at + step
            if (there >= field.shape).any() or (field[tuple(at)] < 0) == (field[tuple(there)] < 0):
                continue
            around = [at - c for c in itertools.product((0, 1), repeat=3) if c[axis] == 0]
            if any((c >= 0).all() and (c < cells.shape).all() and cells[tuple(c)] for c in around):
                f0, f1 = field[tuple(at)], field[tuple(there)]
                vertices.append(at + low + step * np.clip(f0 / (f0 - f1), 1e-3, 0.999))
    return np.array(vertices) * volume.settings.voxel
