"""Find what turns: the region in space whose surface changes in nearly every frame of a standing camera."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.turntable.turning.background import RARE, USUAL, Behind, find_background
from fusion.turntable.turning.noise_seen import noise_over_stated
from fusion.turntable.turning.print_moves import bent_beyond, outline_of, print_moves
from fusion.turntable.turning.visitors import undisturbed, without_visitors

Array = NDArray[np.float64]
Colors = Sequence[NDArray[np.uint8] | None]
EDGE = 0.015  # [m] around what turns that may still be it: mixed pixels reach so far beside it (guess)
# [m] least difference that shows a motion. What stands still wanders by errors that neighbours share, which no noise of
# neighbours shows: at 2 mm the table before the custard box is taken for what turns, 3 to 8 mm serve alike, at 10 mm a
# twelfth of the box is lost
NEAREST = 0.006
# share of a cell's face that must show surface in one frame: mixed pixels along silhouettes string things together
FILLED = 0.05
FLAT = 0.02  # [m] before the background: shadows of stereo and filters bend that by less (guess)
MOSTLY = 0.6  # share of an object that stands so far before the background, unless it is flat (guess)
# share of an outline that stands still in depth: 0.57 and 0.93 of two balls near the axis, 0.04 to 0.25 of five other
# things and of a ball that stood off it (a guess, by scans of one seed)
HOLLOW = 0.5
# of an outline, what moves beyond it by print alone and is bent: 0.16, 0.16, 0.22 of balls and a tower of which half
# was lost, up to 0.05 of other things, 0.004 of a real box on a printed plate (a guess)
BEYOND = 0.08
LEAST = 30  # moving pixels a frame: noise and edges gave 9 where nothing turned, a small object 1100


@dataclass(frozen=True)
class Moving:
    """The region that turns.

    Attributes:
        points: (n, 3) sample of its moving surface, camera frame [m].
        low, high: (3,) box around it, camera frame [m].
        still: (h, w) pixels that see the same depth in all frames: background, plate, what shows no turn.
        wall: (h, w) depth [m] from which on a pixel shows what stands behind; NaN where that is not known.
    """

    points: Array
    low: Array
    high: Array
    still: NDArray[np.bool_]
    wall: NDArray[np.float32]


def find_moving(
    depths: NDArray[np.float32],
    camera: Camera,
    sigma: Callable[[NDArray[np.float32]], NDArray[np.float32]],
    colors: Colors | None = None,
) -> Moving:
    """Find the turning object without a mask.

    What stands before something that was seen behind it at another time has moved. People passing behind move too,
    but no part of space holds them for long: the region kept is the connected one that holds moving surface in nearly
    every frame. What reaches out of it and never moves, followed behind it, is the background; all before that turns.

    Args:
        depths: (k, h, w) a sample of the frames [m], NaN where missing; k from 6 to about 40.
        camera: its camera.
        sigma: the noise of a depth image [m].
        colors: k images (h, w, 3) of the same pixels, None among them where there is none; None for no colours at all.

    Raises:
        TrackingError: when nothing moves.
    """
    behind, moved = look_behind(depths, sigma)
    moved = without_visitors(moved, depths)
    points, frames, stride = _points_of(moved, depths, camera)
    if (by_depth := len(points)) < LEAST * len(depths):
        moved = _by_print(behind, depths, colors)
        points, frames, stride = _points_of(moved, depths, camera)
        if len(points) < LEAST * len(depths):
            raise _nothing(f"{by_depth / len(depths):.0f} moving pixels a frame")
    kept = persistent(points, frames, len(depths), camera.fx**2 / stride)
    if not kept.any():
        raise _nothing("what moves is in no place for long")
    points, frames = points[kept], frames[kept]
    calm = undisturbed(points, frames)
    chosen, visited = points[calm], np.setdiff1d(np.arange(len(depths)), frames[calm])
    behind = _without_print(behind, depths, colors, chosen, camera)
    wall = find_background(behind, outside_of(_box(chosen), behind.far, camera))
    # with it the whole object shows, not only where something was seen behind it
    with np.errstate(invalid="ignore"):
        before = _with_neighbours(np.where(np.isfinite(wall), depths < wall, moved))
        # beside the object its shadow bends a wall, which tells nothing of where it ends unless it is itself so flat
        clear = before & (depths < wall - FLAT)
    if clear.sum() > MOSTLY * before.sum():
        before = clear
    before = without_visitors(before, depths)
    before[visited] = False
    points, frames, stride = _points_of(before, depths, camera)
    chosen = points[persistent(points, frames, len(depths), camera.fx**2 / stride, chosen)]
    return Moving(chosen, *_box(chosen), behind.still, wall)


def find_wall(
    depths: NDArray[np.float32],
    camera: Camera,
    sigma: Callable[[NDArray[np.float32]], NDArray[np.float32]],
    within: tuple[Array, Array],
    colors: Colors | None = None,
) -> NDArray[np.float32] | None:
    """The background (h, w) as `Moving.wall` when the box around what turns is told, which may hold some of it.

    Args:
        depths, camera, sigma, colors: as in `find_moving`.
        within: corners (3,) of the box [m].

    Returns:
        None where nothing is seen to move in the box: all of it counts then.
    """
    behind, moved = look_behind(depths, sigma)
    points, frames, stride = _points_of(moved, depths, camera)
    inside = ((points >= within[0]) & (points <= within[1])).all(axis=1)
    if inside.sum() * stride < LEAST * len(depths):
        return None
    points, frames = points[inside], frames[inside]
    chosen = points[persistent(points, frames, len(depths), camera.fx**2 / stride)]
    behind = _without_print(behind, depths, colors, chosen, camera)
    return find_background(behind, outside_of(_box(chosen), behind.far, camera))


def _nothing(found: str) -> TrackingError:
    return TrackingError(
        "nothing turns in this recording",
        found=found,
        expected="an object on a turntable in front of a camera that stands still",
        do="use `fusion reconstruct` if the camera moved, or give --box",
    )


def _box(points: Array) -> tuple[Array, Array]:
    """Corners (3,) around points (n, 3), the outermost left out. Raises TrackingError: there are none."""
    if not len(points):
        raise _nothing("what moves is in no place for long")
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    return low, high


def look_behind(
    depths: NDArray[np.float32], sigma: Callable[[NDArray[np.float32]], NDArray[np.float32]]
) -> tuple[Behind, NDArray[np.bool_]]:
    """What images (k, h, w) [m] show behind the object, and where something stands before it (k, h, w)."""
    known = np.isfinite(depths)
    count = known.sum(axis=0)
    ordered = np.sort(np.where(known, depths, np.inf), axis=0)
    far, median = (_quantile(ordered, count, q) for q in (0.9, 0.5))
    limit = np.maximum(5 * sigma(median) * noise_over_stated(depths, sigma, median), np.float32(NEAREST))
    with np.errstate(invalid="ignore"):
        still = (known & (np.abs(depths - median) > limit)).sum(axis=0) < 0.1 * np.maximum(count, 1)
        moved = _with_neighbours(known & (depths < far - limit))
    rank = count - 1 - np.maximum(1, np.round(RARE * count)).astype(int)
    farthest = np.take_along_axis(ordered, np.maximum(rank, 0)[None], axis=0)[0]
    farthest = np.where(rank >= 1, farthest, np.nan).astype(np.float32)
    limit = np.where(np.isfinite(limit), limit, np.float32(NEAREST)).astype(np.float32)
    with np.errstate(invalid="ignore"):
        usual = (known & (depths > farthest - limit)).sum(axis=0) > USUAL * np.maximum(count, 1)
    return Behind(farthest, still, still | usual, limit), moved


def _without_print(
    behind: Behind, depths: NDArray[np.float32], colors: Colors | None, points: Array, camera: Camera
) -> Behind:
    """What stands behind, without what only print tells to move; points (n, 3) [m] move by depth.

    That counts where most of an outline stands still, and where something bent goes beyond it: a ball on a plate.
    """
    if colors is None:
        return behind
    outline, usual = outline_of(points, camera), (behind.far, behind.limit)
    moves = print_moves(depths, colors, usual, outline)
    if not (behind.still & outline).sum() > HOLLOW * outline.sum():
        low, high = _box(points)
        beyond = bent_beyond(moves, usual, outline, (low[2] - EDGE, high[2] + EDGE))
        if beyond.sum() < BEYOND * outline.sum():
            return behind
    far = np.where(moves, np.float32(np.nan), behind.far)
    return replace(behind, far=far, still=behind.still & ~moves, usual=behind.usual & ~moves)


def _by_print(behind: Behind, depths: NDArray[np.float32], colors: Colors | None) -> NDArray[np.bool_]:
    """(k, h, w) pixels of what stands still in depth and whose print moves: a bottle that turns about its own axis."""
    if colors is None:
        return np.zeros(depths.shape, bool)
    everywhere = np.ones(depths.shape[1:], bool)
    return print_moves(depths, colors, (behind.far, behind.limit), everywhere) & np.isfinite(depths)


def outside_of(box: tuple[Array, Array], far: NDArray[np.float32], camera: Camera) -> NDArray[np.bool_]:
    """(h, w) bool: pixels whose farthest surface lies outside a box."""
    low, high = box
    z = far.astype(float)
    rays = camera.rays()
    with np.errstate(invalid="ignore"):
        inside = (z > low[2] - EDGE) & (z < high[2] + EDGE)
        for k in range(2):
            at = rays[..., k] * z
            inside &= (at > low[k] - EDGE) & (at < high[k] + EDGE)
    return np.asarray(~inside & np.isfinite(z))


def _with_neighbours(moving: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Without single pixels: at edges these flicker; a moving surface has neighbours."""
    square = np.ones((3, 3), np.uint8)
    return np.stack([cv2.morphologyEx(m.astype(np.uint8), cv2.MORPH_OPEN, square) > 0 for m in moving])


def _quantile(ordered: NDArray[np.float32], count: NDArray[np.int64], q: float) -> NDArray[np.float32]:
    """Quantile (h, w) over the known values of each pixel, which stand first in `ordered` (k, h, w)."""
    index = np.clip((count - 1) * q, 0, None).round().astype(int)
    value = np.take_along_axis(ordered, index[None], axis=0)[0]
    return np.where(count >= 2, value, np.nan).astype(np.float32)


def _points_of(
    moving: NDArray[np.bool_], depths: NDArray[np.float32], camera: Camera
) -> tuple[Array, NDArray[np.int64], int]:
    """Points (n, 3) [m] and frames (n,) of every `stride`-th moving pixel, and the stride."""
    rays = camera.rays()
    frame, v, u = np.nonzero(moving)
    stride = max(1, len(frame) // 400_000)
    frame, v, u = frame[::stride], v[::stride], u[::stride]
    z = depths[frame, v, u].astype(float)
    return np.column_stack([rays[v, u, 0] * z, rays[v, u, 1] * z, z]), frame, stride


def persistent(
    points: Array, frames: NDArray[np.int64], n_frames: int, density: float, near: Array | None = None
) -> NDArray[np.bool_]:
    """(n,) bool: points in the largest connected region that holds moving surface in most frames.

    Args:
        points, frames: (n, 3) [m], (n,).
        n_frames: how many there are.
        density: points that a surface square to the sight has per steradian in one frame.
        near: (m, 3) points that the region must hold, when some are known.
    """
    if not len(points):
        raise _nothing("what moves is in no place for long")
    cell = max(0.01, float(np.median(points[:, 2])) / 60)
    low = points.min(axis=0)
    while np.prod(np.ptp(points, axis=0) // cell + 1) > 3e7:  # far outliers: coarser cells keep this small
        cell *= 2
    index = np.floor((points - low) / cell).astype(int)
    shape = index.max(axis=0) + 1
    flat = np.ravel_multi_index(tuple(index.T), tuple(shape))
    both, counts = np.unique(flat * n_frames + frames, return_counts=True)
    place = np.unravel_index(both // n_frames, shape)
    enough = counts >= FILLED * density * (cell / np.maximum(low[2] + cell * place[2], cell)) ** 2
    occupied = np.zeros(shape, bool)
    occupied[tuple(axis[enough] for axis in place)] = True
    labels, n = ndimage.label(occupied, np.ones((3, 3, 3)))
    label = labels[tuple(index.T)]
    present = np.zeros((n + 1, n_frames), np.int64)
    np.add.at(present, (label, frames), 1)
    present[0] = 0  # no region
    size = present.sum(axis=1)
    least = np.maximum(5, 0.1 * size / n_frames)[:, None]
    persistence = (present >= least).mean(axis=1)
    if near is not None:
        at = np.clip(np.floor((near - low) / cell).astype(int), 0, shape - 1)
        persistence *= np.bincount(labels[tuple(at.T)], minlength=n + 1) > 0.1 * len(near)
    # of the regions that are there in nearly every frame, the one with most surface
    score = np.where(persistence > 0.6 * np.max(persistence), size, 0)
    return np.asarray(label == np.argmax(score))
