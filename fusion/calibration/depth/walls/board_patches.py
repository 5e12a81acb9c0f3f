"""Where a checkerboard's squares lie in the image: bright and dark ones answer apart, as brightness moves the depth."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.tiles import TileGrid, side_of
from fusion.calibration.lens.boards.board import Board
from fusion.geometry.camera import Camera

EDGE = 4.5  # [px] from a square's edge: dark ones read 7 mm too far up to 3 px inside, a median of nine sees 1 more
SMALLEST = 5.0  # [px] side of a square whose middle 3 x 3 px see no other
HALF = 0.5  # share of a patch's pixels that must have a depth
Array = NDArray[np.floating]


def square_centres(board: Board) -> NDArray:
    """(n, 3) centres [m] of the squares between the inner corners, row by row."""
    v, u = np.mgrid[0 : board.rows - 1, 0 : board.columns - 1]
    across = [u.ravel() + 0.5, v.ravel() + 0.5, np.zeros(u.size)]
    return np.asarray(np.array(across, float).T * board.square_m, float)


def projected(points: Array, pose: Array, camera: Camera) -> Array:
    """(n, 2) pixels of points (n, 3) of the board; pose (6,): rotation vector and shift to the camera."""
    pixels, _ = cv2.projectPoints(points, pose[:3], pose[3:], camera.matrix, np.array(camera.distortion))
    return np.asarray(pixels, float).reshape(-1, 2)


def patches(board: Board, pose: Array, camera: Camera) -> NDArray[np.intp] | None:
    """(h, w) number of the square whose middle a pixel sees, -1 elsewhere; None where the squares are too small."""
    centres = square_centres(board)
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.5 * board.square_m
    quads = projected((centres[:, None] + corners).reshape(-1, 3), pose, camera).reshape(-1, 4, 2)
    side = float(np.min(np.linalg.norm(np.roll(quads, 1, axis=1) - quads, axis=2)))
    if not np.isfinite(quads).all() or side < SMALLEST:
        return None
    middles = projected(centres, pose, camera)
    quads = middles[:, None] + (quads - middles[:, None]) * max(1 - 2 * EDGE / side, 0.0)
    label = np.full(camera.shape, -1, np.int32)
    for number, (quad, middle) in enumerate(zip(quads, middles, strict=True)):
        u, v = np.rint(middle).astype(int)
        if 1 <= u < camera.width - 1 and 1 <= v < camera.height - 1:
            cv2.fillConvexPoly(label, np.rint(quad).astype(np.int32), number)
    return label.astype(np.intp)


def tiles_of_patches(label: NDArray[np.intp], mask: NDArray[np.bool_]) -> TileGrid:
    """The patches as tiles; `mask` (h, w) says which of their pixels have a depth."""
    inside = (label >= 0) & mask
    most = int(np.max(label)) + 1
    all_of = np.bincount(label[label >= 0], minlength=most)
    counts = np.bincount(label[inside], minlength=most)
    kept = np.flatnonzero(counts > HALF * all_of)
    number = np.full(most, -1)
    number[kept] = np.arange(len(kept))
    label = np.asarray(np.where(inside, number[label], -1), np.intp)
    rows, columns = np.nonzero(label >= 0)
    own = label[rows, columns]
    height, width = label.shape
    side = side_of(width)
    middle = [np.bincount(own, x, len(kept)) / counts[kept] // side for x in (rows, columns)]
    return TileGrid(
        label, counts[kept], np.column_stack(middle).astype(np.intp), (-(-height // side), -(-width // side)), side
    )
