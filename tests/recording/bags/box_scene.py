"""A box before a tilted plane, seen by any camera: depth by formula, without the program. numpy alone is needed."""

import numpy as np

# of no symmetry: a mirrored, turned or shifted image shows another
LOW, HIGH = np.array([-0.11, -0.06, 0.62]), np.array([0.07, 0.13, 0.75])
NORMAL, OFFSET = np.array([0.25, -0.4, 1.0]), 1.1
# what moves the camera from frame to frame [m]
STEP = np.array([0.004, -0.002, 0.003])


def depth(rays, frame=0):
    """(h, w) planar z [m] along rays (h, w, 2) of x/z and y/z, from where the camera stands at a frame."""
    eye = frame * STEP
    along = np.dstack([rays, np.ones(rays.shape[:2])]).astype(float)
    wall = (OFFSET - NORMAL @ eye) / (along @ NORMAL)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(corner - eye) / along for corner in (LOW, HIGH)])
    near, far = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
    return np.where((near < far) & (near > 0), np.minimum(near, wall), wall)


def rays(width, height, fx, fy, cx, cy):
    """(h, w, 2) of a camera without a lens; pixel (0, 0) is the centre of the first."""
    v, u = np.mgrid[0:height, 0:width].astype(float)
    return np.dstack([(u - cx) / fx, (v - cy) / fy])


def color(width, height, frame=0):
    """(h, w, 3) uint8: each pixel tells its place."""
    v, u = np.mgrid[0:height, 0:width]
    return np.stack([2 * u % 256, 2 * v % 256, np.full_like(u, 10 * frame)], axis=-1).astype(np.uint8)
