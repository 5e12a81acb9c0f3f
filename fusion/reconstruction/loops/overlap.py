"""Which views show the same surface, as far as the poses tell."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array, inverse
from fusion.reconstruction.loops.keyframes import Keyframe

SLACK = 0.1  # of the depth, by which two surfaces may miss each other and be the same (guess: the drift of a room)
APART = 0.15  # of its points in the other's view: less is another place

HALF = 0.5  # of what two views share: a view between them that shares less stands elsewhere (guess)


def overlaps(frames: Sequence[Keyframe], poses: Array) -> NDArray[np.float64]:
    """(n, n) share of the points of view j that view i shows too, at poses (n, 4, 4); the smaller of both ways.

    0 where views lie in different pieces: their poses are no common ones yet.
    """
    n = len(frames)
    shares = np.zeros((n, n))
    depths = [frame.surface.points[..., 2] for frame in frames]
    world = [frame.sample @ T[:3, :3].T + T[:3, 3] for frame, T in zip(frames, poses, strict=True)]
    back = inverse(poses)
    for i, frame in enumerate(frames):
        camera = frame.surface.camera
        same = [j for j in range(n) if frames[j].piece == frame.piece and len(world[j])]
        if not same:
            continue
        points = np.concatenate([world[j] for j in same]) @ back[i, :3, :3].T + back[i, :3, 3]
        z = points[:, 2]
        ahead = np.flatnonzero(z > 0.05)
        pixels = np.full((len(points), 2), -1)
        # a lens bends the image by few pixels: no matter for a share
        flat = points[ahead, :2] / z[ahead, None] * (camera.fx, camera.fy) + (camera.cx, camera.cy)
        pixels[ahead] = np.rint(np.clip(flat, -1, 1e6))
        u, v = pixels.T
        inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
        there = np.full(len(points), np.nan)
        there[inside] = depths[i][v[inside], u[inside]]
        shown = np.abs(there - z) < SLACK * z
        owner = np.repeat(same, [len(world[j]) for j in same])
        counts = np.bincount(owner, minlength=n)
        shares[i] = np.bincount(owner, shown, n) / np.maximum(counts, 1)
    return np.minimum(shares, shares.T)


def left_and_met(shares: NDArray[np.float64], enough: float) -> list[tuple[int, int]]:
    """Pairs (i, j), i < j, that share enough, between which the camera saw less than half of that."""
    n = len(shares)
    pairs = []
    for i in range(n - 2):
        least = np.minimum.accumulate(shares[i, i + 1 :])[:-1]
        here = shares[i, i + 2 :]
        pairs += [(i, i + 2 + int(k)) for k in np.flatnonzero((here > enough) & (least < HALF * here))]
    return pairs
