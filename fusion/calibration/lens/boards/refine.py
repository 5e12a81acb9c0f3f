"""Corners to a fraction of a pixel, in the picture at its own size."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.grid import neighbour_distance, plane_misfit
from fusion.calibration.lens.boards.saddle import saddles
from fusion.geometry.pose import Array

STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 60, 1e-4)
# half windows, as shares of the distance between corners: the widest averages most noise away (measured: 0.6 leaves a
# tenth to a fifth less reprojection error than 0.45), a narrow one sees less of a glare; from 0.75 on the window sees
# the next corner and runs away
WINDOWS = (0.6, 0.45, 0.3)
NARROWEST, WIDEST = 2, 12  # [px]


def counts(image: NDArray) -> NDArray[np.float32]:
    """(height, width) grey values of a grey or RGB picture; 0 where they are not finite."""
    grey = np.asarray(image)
    if grey.ndim == 3:
        grey = cv2.cvtColor(np.ascontiguousarray(grey[..., :3]), cv2.COLOR_RGB2GRAY)
    return np.nan_to_num(grey.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)


def refined(image: NDArray, pixels: Array, board: Board) -> Array:
    """Corners (columns * rows, 2) [px] moved to where the gradients around them point.

    Of several windows the one is taken whose corners are nearest to a plane board; from there the edges are fitted.
    """
    values = board_contrast(image, pixels)
    grey = np.round(values * 255).astype(np.uint8)
    distance = neighbour_distance(pixels, board)
    halves = sorted({int(np.clip(share * distance, NARROWEST, WIDEST)) for share in WINDOWS}, reverse=True)
    plane = board.points()[:, :2]
    moved = [move(grey, pixels, half) for half in halves]
    best = min(moved, key=lambda corners: plane_misfit(plane, corners)[0])
    return saddles(values, best, plane / board.square_m)


def move(grey: NDArray[np.uint8], pixels: Array, half: int) -> Array:
    """Corners (n, 2) [px] refined in windows of 2 * half + 1 px; one that ran away stays where it was."""
    start = np.ascontiguousarray(pixels.reshape(-1, 1, 2), np.float32)
    moved = cv2.cornerSubPix(grey, start.copy(), (half, half), (-1, -1), STOP).reshape(-1, 2).astype(float)
    astray = ~(np.linalg.norm(moved - pixels, axis=1) <= max(half, 2))
    return np.where(astray[:, None], pixels, moved)


def board_contrast(image: NDArray, pixels: Array) -> NDArray[np.float32]:
    """(height, width) 0 to 1, the contrast of the board's own squares: glare becomes plain white instead of an edge."""
    values = counts(image)
    inside = np.zeros(values.shape, np.uint8)
    cv2.fillConvexPoly(inside, cv2.convexHull(np.round(pixels).astype(np.int32)), 1)
    seen = values[inside > 0]
    dark, bright = np.percentile(seen if len(seen) else values, [3, 75])
    # one and a fifth of the squares' white keeps bright squares of a board in uneven light apart from each other
    high = dark + 1.2 * max(bright - dark, 1e-6)
    return np.clip((values - dark) / (high - dark), 0, 1).astype(np.float32)
