"""Find what turns: the region in space whose surface changes in nearly every frame of a standing camera."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera

Array = NDArray[np.float64]
LEAST = 30  # moving pixels a frame: noise and edges gave 9 where nothing turned, a small object 1100


@dataclass(frozen=True)
class Moving:
    """The region that turns.

    Attributes:
        points: (n, 3) sample of its moving surface, camera frame [m].
        low, high: (3,) box around it, camera frame [m].
        still: (h, w) pixels that see the same depth in all frames: background, plate, what shows no turn.
    """

    points: Array
    low: Array
    high: Array
    still: NDArray[np.bool_]


def find_moving(
    depths: NDArray[np.float32], camera: Camera, sigma: Callable[[NDArray[np.float32]], NDArray[np.float32]]
) -> Moving:
    """Find the turning object without a mask.

    What stands before something that was seen behind it at another time has moved. People passing behind move too,
    but no part of space holds them for long: the region kept is the connected one that holds moving surface in nearly
    every frame.

    Args:
        depths: (k, h, w) a sample of the frames [m], NaN where missing; k from 6 to about 40.
        camera: its camera.
        sigma: the noise of a depth image [m].

    Raises:
        TrackingError: when nothing moves.
    """
    known = np.isfinite(depths)
    count = known.sum(axis=0)
    ordered = np.sort(np.where(known, depths, np.inf), axis=0)
    far, median = (_quantile(ordered, count, q) for q in (0.9, 0.5))
    limit = np.maximum(5 * sigma(median), 0.006)
    still = (known & (np.abs(depths - median) > limit)).sum(axis=0) < 0.1 * np.maximum(count, 1)
    # single pixels at edges flicker; a moving surface has neighbours
    square = np.ones((3, 3))
    moving = np.stack([ndimage.binary_opening(mask, square) for mask in known & (depths < far - limit)])
    points, frames = _points_of(moving, depths, camera)
    if len(points) < LEAST * len(depths):
        raise TrackingError(
            "nothing turns in this recording",
            found=f"{len(points) / len(depths):.0f} moving pixels a frame",
            expected="an object on a turntable in front of a camera that stands still",
            do="use `fusion reconstruct` if the camera moved, or give --box",
        )
    chosen = points[_persistent(points, frames, len(depths), float(np.median(points[:, 2])))]
    low, high = np.percentile(chosen, [0.5, 99.5], axis=0)
    return Moving(chosen, low, high, still)


def _quantile(ordered: NDArray[np.float32], count: NDArray[np.int64], q: float) -> NDArray[np.float32]:
    """Quantile (h, w) over the known values of each pixel, which stand first in `ordered` (k, h, w)."""
    index = np.clip((count - 1) * q, 0, None).round().astype(int)
    value = np.take_along_axis(ordered, index[None], axis=0)[0]
    return np.where(count >= 2, value, np.nan).astype(np.float32)


def _points_of(moving: NDArray[np.bool_], depths: NDArray[np.float32], camera: Camera) -> tuple[Array, NDArray]:
    rays = camera.rays()
    frame, v, u = np.nonzero(moving)
    stride = max(1, len(frame) // 400_000)
    frame, v, u = frame[::stride], v[::stride], u[::stride]
    z = depths[frame, v, u].astype(float)
    return np.column_stack([rays[v, u, 0] * z, rays[v, u, 1] * z, z]), frame


def _persistent(points: Array, frames: NDArray, n_frames: int, distance: float) -> NDArray[np.bool_]:
    """(n,) bool: points in the largest connected region that holds moving surface in most frames."""
    cell = max(0.01, distance / 60)
    index = np.floor((points - points.min(axis=0)) / cell).astype(int)
    shape = index.max(axis=0) + 1
    if np.prod(shape.astype(float)) > 3e7:  # far outliers: coarser cells keep this small
        return _persistent(points, frames, n_frames, distance * 2)
    occupied = np.zeros(shape, bool)
    occupied[tuple(index.T)] = True
    labels, n = ndimage.label(occupied, np.ones((3, 3, 3)))
    label = labels[tuple(index.T)]
    present = np.zeros((n + 1, n_frames), np.int64)
    np.add.at(present, (label, frames), 1)
    size = present.sum(axis=1)
    enough = np.maximum(5, 0.1 * size / n_frames)[:, None]
    persistence = (present >= enough).mean(axis=1)
    # of the regions that are there in nearly every frame, the one with most surface
    score = np.where(persistence > 0.6 * np.max(persistence), size, 0)
    return np.asarray(label == np.argmax(score))
