"""Does a surface say by itself that the camera did not move along it?"""

import numpy as np
from numpy.typing import NDArray

CELL = 8  # [px] depth is averaged over cells, or noise would tilt the normals
FLAT = 0.05  # of the depth: neighbouring cells that differ by more lie on two surfaces
ENOUGH = 50  # cells
# m along the normals per metre of motion: planes of real and simulated recordings reach 0.056 in the second weakest
# direction, a wall with a table before it 0.15
HELD = 0.1


def holds_the_camera(depth: NDArray[np.floating], rays: NDArray[np.floating]) -> bool:
    """True when at most one motion of the camera leaves all distances along the normals as they are.

    A single plane looks the same while the camera slides along it or turns about its normal; along the edge between
    table and wall only a straight slide is left, which nobody does while all else stays in its place.

    Args:
        depth: (h, w) [m], NaN where the surface is not asked.
        rays: (h, w, 2) x/z and y/z of its pixels.
    """
    points, normals = _facets(depth, rays)
    if len(points) < ENOUGH:
        return False
    arm = points - points.mean(axis=0)
    size = np.sqrt((arm**2).sum(axis=1).mean())
    rows = np.hstack([np.cross(arm, normals) / size, normals])
    return bool(np.sqrt(max(np.linalg.eigvalsh(rows.T @ rows / len(rows))[1], 0.0)) > HELD)


def _facets(depth: NDArray[np.floating], rays: NDArray[np.floating]) -> tuple[NDArray, NDArray]:
    """Points and unit normals (n, 3) of cells whose right and lower neighbours lie on the same surface."""
    height, width = (side // CELL for side in depth.shape)
    blocks = depth[: height * CELL, : width * CELL].reshape(height, CELL, width, CELL)
    mean = blocks.mean(axis=(1, 3), dtype=float)  # NaN where any pixel is
    ray = rays[: height * CELL, : width * CELL].reshape(height, CELL, width, CELL, 2).mean(axis=(1, 3))
    points = np.dstack([ray * mean[..., None], mean])
    across, down = points[:-1, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, :-1]
    near = FLAT * mean[:-1, :-1]
    with np.errstate(invalid="ignore"):
        joined = (np.abs(across[..., 2]) < near) & (np.abs(down[..., 2]) < near)
    normals = np.cross(across[joined], down[joined])
    return points[:-1, :-1][joined], normals / np.linalg.norm(normals, axis=1, keepdims=True)
