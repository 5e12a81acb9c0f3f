"""The corners of a ChArUco board in one picture; part of the board is enough."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.detect import FoundCorners, stretched
from fusion.calibration.lens.boards.refine import REACH, board_contrast, move, saddles
from fusion.geometry.pose import Array

FEWEST_CORNERS = 6  # a view with fewer says little more than its own pose
# (enlarged, smoothed [px]): speckle hides the bits of a marker, and small bits are read better when enlarged
ATTEMPTS = ((1, 0.0), (1, 1.0), (2, 1.0), (3, 1.0))
LARGEST_SEARCH = 3200  # [px] enlarging is for small pictures
ENOUGH = 0.8  # of the corners: no further attempt
NARROWEST, WIDEST = 2, 8  # [px] half windows


def find_charuco(image: NDArray, board: Board) -> FoundCorners | None:
    """The corners of the board that are seen, or None; both layouts of boards with even rows are tried."""
    grey = stretched(image)
    best: FoundCorners | None = None
    for scale, blur in ATTEMPTS:
        if scale > 1 and scale * max(grey.shape) > LARGEST_SEARCH:
            continue
        picture: Any = cv2.GaussianBlur(grey, (0, 0), blur) if blur else grey
        if scale > 1:
            picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        for legacy in (False, True):
            found = _find(picture, board, legacy, scale)
            if found is not None and (best is None or len(found.ids) > len(best.ids)):
                best = found
        if best is not None and len(best.ids) > ENOUGH * board.corners:
            break
    return None if best is None else replace(best, pixels=_refined(image, best, board))


def _refined(image: NDArray, found: FoundCorners, board: Board) -> Array:
    """Corners (n, 2) [px] refined at the picture's own size, in windows that no marker reaches into."""
    pixels = found.pixels
    distance = np.linalg.norm(pixels[:, None] - pixels, axis=2)
    np.fill_diagonal(distance, np.inf)
    share = 0.5 * (1 - board.marker_m / board.square_m)
    half = int(np.clip(share * np.median(distance.min(axis=1)), NARROWEST, WIDEST))
    values = board_contrast(image, pixels)
    moved = move(np.round(values * 255).astype(np.uint8), pixels, half)
    plane = board.points()[found.ids, :2] / board.square_m
    return saddles(values, moved, plane, min(REACH, 0.9 * share))


def _find(grey: NDArray[np.uint8], board: Board, legacy: bool, scale: int) -> FoundCorners | None:
    """The corners in an enlarged picture, in pixels of the picture itself."""
    markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    squares = (board.columns + 1, board.rows + 1)
    layout = cv2.aruco.CharucoBoard(squares, board.square_m, board.marker_m, markers)
    layout.setLegacyPattern(legacy)
    how = cv2.aruco.DetectorParameters()
    how.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE  # the board's corners are refined, not the markers'
    try:
        corners, ids, _, _ = cv2.aruco.CharucoDetector(layout, cv2.aruco.CharucoParameters(), how).detectBoard(grey)
    except cv2.error:
        return None
    if ids is None or len(ids) < FEWEST_CORNERS:
        return None
    index = np.asarray(ids).reshape(-1).astype(np.intp)
    across, down = np.unique(index % board.columns), np.unique(index // board.columns)
    if len(across) < 2 or len(down) < 2:  # on one line: no plane
        return None
    pixels = (np.asarray(corners, float).reshape(-1, 2) + 0.5) / scale - 0.5
    return FoundCorners(index, pixels, "markers" + (" (legacy layout)" if legacy else ""))
