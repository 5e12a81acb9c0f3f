"""Corners to a fraction of a pixel, in the picture at its own size."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.grid import neighbour_distance, plane_misfit
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


REACH = 0.7  # of a square to each side: the next corner's edges stay outside, blur included
MOST_PIXELS, FEWEST_PIXELS = 1200, 16
ROUNDS = 12
BLUR_PX = (0.3, 3.0)
ASTRAY = 0.02  # of a square, and 0.4 px: a corner that moves further was disturbed by something else
MISFIT, WORSE = 0.2, 3.0  # of the contrast, or times that of the other corners: no plain corner


def saddles(grey: NDArray, pixels: Array, plane: Array, reach: float = REACH) -> Array:
    """Corners (n, 2) [px] moved to the crossing of their edges; those that cannot be fitted stay where they are.

    Args:
        grey: (height, width) grey values.
        pixels: (n, 2) start [px].
        plane: (n, 2) the same corners on the board, in squares.
        reach: how far around a corner pixels are used, in squares.
    """
    H, _ = cv2.findHomography(plane, pixels)
    if H is None:
        return pixels
    fits = [_crossing(grey, pixel, _edges(H, at), reach) for pixel, at in zip(pixels, plane, strict=True)]
    misfit = np.array([fit[2] for fit in fits])
    # speckle and little light are alike for all corners, a glare or a finger is not
    usable = misfit <= max(MISFIT, WORSE * float(np.median(misfit)))
    return np.where(usable[:, None], [fit[:2] for fit in fits], pixels)


def _edges(H: NDArray, at: Array) -> Array:
    """(2, 2) pixels per square along both edges through a corner of the board."""
    x, y, w = H @ [*at, 1.0]
    return (H[:2, :2] - np.outer([x / w, y / w], H[2, :2])) / w


def _crossing(grey: NDArray, start: Array, edges: Array, reach: float) -> tuple[float, float, float]:
    """Where the edges cross [px], by Gauss-Newton in place and blur; contrast and light are solved for.

    Returns:
        u, v and the misfit: rms of what is left over the contrast, infinite where nothing could be fitted.
    """
    nothing = (float(start[0]), float(start[1]), float("inf"))
    if not np.isfinite(edges).all() or abs(np.linalg.det(edges)) < 1.0:
        return nothing
    to_board = np.linalg.inv(edges)
    across = 1 / np.linalg.norm(to_board, axis=1)  # pixels from an edge, per square
    at, values = _around(grey, start, edges, reach)
    if len(values) < FEWEST_PIXELS:
        return nothing
    corner, blur = start.copy(), 0.8
    for _ in range(ROUNDS):
        away = at - corner
        distance = away @ to_board.T * across
        side = erf(distance / (blur * np.sqrt(2)))
        slope = np.exp(-0.5 * (distance / blur) ** 2) * np.sqrt(2 / np.pi) / blur
        checker = side[:, 0] * side[:, 1]
        light = np.column_stack([np.ones(len(values)), checker, away, away * checker[:, None]])
        amounts = _least_squares(light, values)
        left = values - light @ amounts
        steep = slope * side[:, ::-1] * amounts[1]
        design = np.column_stack([light, -(steep * across) @ to_board, -(steep * distance).sum(axis=1) / blur])
        step = _least_squares(design, left)[-3:]
        corner = corner + np.clip(step[:2], -1, 1)
        blur = float(np.clip(blur + np.clip(step[2], -0.2, 0.2), *BLUR_PX))
        if np.abs(step[:2]).max() < 1e-4:
            break
    if not np.linalg.norm(corner - start) < ASTRAY * float(np.min(across)) + 0.4:
        return nothing
    return float(corner[0]), float(corner[1]), float(np.sqrt((left**2).mean()) / max(abs(amounts[1]), 1e-12))


def _least_squares(design: Array, values: Array) -> Array:
    """(k,) amounts of the columns (n, k); by normal equations: tens of thousands of these are solved."""
    normal = design.T @ design
    normal[np.diag_indices_from(normal)] *= 1 + 1e-9  # a corner without contrast leaves a column open
    normal[np.diag_indices_from(normal)] += 1e-12
    return np.asarray(np.linalg.solve(normal, design.T @ values), float)


def _around(grey: NDArray, start: Array, edges: Array, reach: float) -> tuple[Array, Array]:
    """(n, 2) pixels within `reach` squares of a corner, and their values (n,); fewer squares where these are large."""
    reach = min(reach, 0.5 * float(np.sqrt(MOST_PIXELS / abs(np.linalg.det(edges)))))
    far = np.ceil(np.abs(edges).sum(axis=1) * reach).astype(int)
    low = np.maximum(np.round(start).astype(int) - far, 0)
    high = np.minimum(np.round(start).astype(int) + far + 1, grey.shape[::-1])
    v, u = np.mgrid[low[1] : high[1], low[0] : high[0]]
    at = np.stack([u.ravel(), v.ravel()], axis=1).astype(float)
    near = (np.abs((at - start) @ np.linalg.inv(edges).T) < reach).all(axis=1)
    at = at[near]
    return at, grey[at[:, 1].astype(int), at[:, 0].astype(int)].astype(float)
