"""Slow twins of the volume's kernels: plain loops, double precision, no blocks skipped."""

import itertools

import numpy as np

from fusion.geometry.pose import inverse
from fusion.volume.blocks import by_voxel

BLOCK = 8


def planes_twin(depth, camera, truncation, steep=0.1, edge=0.5, edge_weight=0.01):
    """(h, w, 3) normals, (h, w) distances of the planes that touch the surface at each pixel, weights, and depths."""
    h, w = camera.shape
    inverse = np.zeros((h + 2, w + 2))
    inverse[1:-1, 1:-1] = np.divide(1, depth, where=depth > 0, out=np.zeros((h, w)))
    rays = np.dstack([camera.rays(), np.ones((h, w))]).astype(float)
    (yv, yu), (xv, xu) = np.gradient(rays[..., 1]), np.gradient(rays[..., 0])
    normal, distance, weight, smooth = np.zeros((h, w, 3)), np.zeros((h, w)), np.zeros((h, w)), np.zeros((h, w))
    for v, u in np.argwhere(depth > 0):
        around = inverse[v : v + 3, u : u + 3]
        i, least = around[1, 1], steep
        with np.errstate(divide="ignore"):
            same = np.abs(1 / around - 1 / i) < truncation
        whole = same.all()
        if whole:
            du, dv = (around[:, 2] - around[:, 0]).sum() / 6, (around[2] - around[0]).sum() / 6
            i = i / 2 + (around[0, 1] + around[2, 1] + around[1, 0] + around[1, 2]) / 8
        else:
            slopes = []
            for sides in ((1, slice(None)), (slice(None), 1)):
                (one, here, other), (before, _, after) = around[sides], same[sides]
                step = (other if after else here) - (one if before else here)
                slopes.append(step / max(int(before) + int(after), 1))
                least = least if before or after else edge
            du, dv = slopes
        J = np.array([[xu[v, u], yu[v, u]], [xv[v, u], yv[v, u]]])  # of x/z, y/z along u, along v
        n = np.append(np.linalg.solve(J, [du, dv]), 0.0)
        n[2] = i - n @ rays[v, u]
        slant = max(i / np.linalg.norm(n), least)
        normal[v, u], distance[v, u] = n * slant / i, slant / i
        weight[v, u], smooth[v, u] = slant * (1 if whole else edge_weight), 1 / i
    return normal, distance, weight, smooth


def integrate_twin(blocks, depth, camera, T, voxel, truncation):
    """Sums (n, 8, 8, 8, 2) of weight * distance and weight that one frame adds to blocks at coordinates (n, 3)."""
    h, w = camera.shape
    depth = np.where(np.isfinite(depth) & (depth > 0), depth, 0.0)
    normal, distance, weight, smooth = planes_twin(depth, camera, truncation)
    out = np.zeros((len(blocks), BLOCK, BLOCK, BLOCK, 2))
    indices = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), -1)
    for n, block in enumerate(blocks):
        points = (block * BLOCK + indices).reshape(-1, 3) * voxel
        local = points @ inverse(T)[:3, :3].T + inverse(T)[:3, 3]
        front = local[:, 2] > 1e-6
        pixels = np.full((len(points), 2), -9.0)
        pixels[front] = camera.project(local[front])
        for q in np.flatnonzero(front):
            u, v = np.floor(pixels[q] + 0.5).astype(int)
            if 0 <= u < w and 0 <= v < h and depth[v, u] > 0 and smooth[v, u] - local[q, 2] > -truncation:
                d = min(distance[v, u] - normal[v, u] @ local[q], truncation)
                out[n].reshape(-1, 2)[q] = weight[v, u] * d, weight[v, u]
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
