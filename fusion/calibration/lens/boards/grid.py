"""Whether corners form a board, and which way round they are counted."""

import cv2
import numpy as np

from fusion.calibration.lens.boards.board import Board
from fusion.geometry.pose import Array

# a lens bends a board by less than this share of a square between neighbours; a misplaced corner by more
UNEVEN_SHARE = 0.4
SMALLEST_PX = 2.0  # neighbours nearer than this cannot be told apart


def neighbour_distance(pixels: Array, board: Board) -> float:
    """Shortest distance [px] between neighbouring corners (columns * rows, 2)."""
    grid = pixels.reshape(board.rows, board.columns, 2)
    along, down = np.diff(grid, axis=1), np.diff(grid, axis=0)
    return float(min(np.min(np.linalg.norm(along, axis=2)), np.min(np.linalg.norm(down, axis=2))))


def implausible(pixels: Array, board: Board, shape: tuple[int, ...]) -> str:
    """Why corners (columns * rows, 2) [px] are no board in a picture of this shape; empty when they may be one."""
    if not np.isfinite(pixels).all() or (pixels < -0.5).any() or (pixels > np.array(shape[1::-1]) - 0.5).any():
        return "corners outside of the picture"
    if neighbour_distance(pixels, board) < SMALLEST_PX:
        return "corners too close together"
    _, misfit = plane_misfit(board.points()[:, :2], pixels)
    if misfit > UNEVEN_SHARE * neighbour_distance(pixels, board):
        return f"a corner lies {misfit:.1f} px beside a plane board"
    grid = pixels.reshape(board.rows, board.columns, 2)
    # along every row and column, the distances change slowly
    for steps in (np.diff(grid, axis=1), np.diff(grid, axis=0).transpose(1, 0, 2)):
        length = np.linalg.norm(steps, axis=2)
        if (np.abs(np.diff(length, axis=1)) > UNEVEN_SHARE * np.minimum(length[:, 1:], length[:, :-1])).any():
            return "neighbouring squares differ too much"
    return ""


def plane_misfit(plane: Array, pixels: Array) -> tuple[float, float]:
    """(rms, largest) distance [px] of corners (n, 2) from the best perspective picture of a plane's points (n, 2)."""
    H, _ = cv2.findHomography(plane, pixels)
    if H is None:
        return float("inf"), float("inf")
    distance = np.linalg.norm(cv2.perspectiveTransform(plane[None], H)[0] - pixels, axis=1)
    return float(np.sqrt((distance**2).mean())), float(distance.max())


def upright(pixels: Array, board: Board) -> Array:
    """The same corners (columns * rows, 2), counted so that x runs to the right and y down as nearly as can be.

    A checkerboard looks the same from both ends; this choice is the same for two cameras that stand side by side.
    """
    grid = pixels.reshape(board.rows, board.columns, 2)
    along = (grid[:, -1] - grid[:, 0]).sum(axis=0)
    down = (grid[-1] - grid[0]).sum(axis=0)
    if along[0] * down[1] - along[1] * down[0] < 0:  # mirrored: a board is not seen from behind
        grid = grid[:, ::-1]
    turns = range(4) if board.rows == board.columns else range(0, 4, 2)
    turned = [np.rot90(grid, turn) for turn in turns]
    best = max(turned, key=lambda g: float((g[:, -1] - g[:, 0]).sum(axis=0) @ [1, 0] + (g[-1] - g[0]).sum(axis=0)[1]))
    return np.ascontiguousarray(best).reshape(-1, 2)
