"""Points and normals of a depth image in plain numpy, slow and simple."""

import numpy as np

from fusion.geometry.relief import NEIGHBOURS, RADIUS, REACH, STEEP, WIDTH


def moved(image, by, axis):
    """The pixel `by` further on, NaN beyond the border."""
    out = np.full_like(image, np.nan)
    n = image.shape[axis]
    if abs(by) >= n:
        return out
    to = [slice(None)] * image.ndim
    source = [slice(None)] * image.ndim
    to[axis], source[axis] = slice(max(0, -by), n - max(0, by)), slice(max(0, by), n + min(0, by))
    out[tuple(to)] = image[tuple(source)]
    return out


def averaged(depth, step, axis):
    weights, total = np.zeros_like(depth), np.zeros_like(depth)
    for k in range(-RADIUS, RADIUS + 1):
        other = moved(depth, k, axis)
        alike = np.clip(1 - ((other - depth) / (NEIGHBOURS * step)) ** 2, 0, None) ** 2
        weight = np.nan_to_num(alike * np.exp(-0.5 * (k / WIDTH) ** 2))
        weights += weight
        total += weight * np.nan_to_num(other)
    return np.where(np.isfinite(depth), total / np.where(weights > 0, weights, 1), np.nan)


def relief(depth, camera, sigma, step):
    """Normals (h, w, 3) as `fusion.geometry.relief` makes them."""
    depth = depth.astype(float)
    smooth = averaged(averaged(depth, step, 1), step, 0)
    points = np.concatenate([camera.rays() * smooth[..., None], smooth[..., None]], axis=2)
    across = moved(points, REACH, 1) - moved(points, -REACH, 1)
    down = moved(points, REACH, 0) - moved(points, -REACH, 0)
    normals = np.cross(down, across)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    limit = STEEP / camera.fx * depth + 3 * sigma
    for axis, by in ((0, 1), (0, -1), (1, 1), (1, -1)):
        normals[~(np.abs(moved(depth, by, axis) - depth) < limit)] = np.nan
    return normals
