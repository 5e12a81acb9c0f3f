"""The corners of a ChArUco board in one picture; part of the board is enough."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.board import Board
from fusion.calibration.lens.detect import Found, stretched

FEWEST_CORNERS = 6  # a view with fewer says little more than its own pose
SMOOTHED = (0.0, 1.0)  # [px] speckle hides the bits of a marker


def find_charuco(image: NDArray, board: Board) -> Found | None:
    """The corners of the board that are seen, or None; both layouts of boards with even rows are tried.

    Args:
        image: (height, width) or (height, width, 3).
        board: with markers.
    """
    grey = stretched(image)
    best: Found | None = None
    for blur in SMOOTHED:
        picture: Any = cv2.GaussianBlur(grey, (0, 0), blur) if blur else grey
        for legacy in (False, True):
            found = _find(picture, board, legacy)
            if found is not None and (best is None or len(found.ids) > len(best.ids)):
                best = found
        if best is not None and len(best.ids) > board.corners // 2:
            break
    return best


def _find(grey: NDArray[np.uint8], board: Board, legacy: bool) -> Found | None:
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
    pixels = np.asarray(corners, float).reshape(-1, 2)
    return Found(index, pixels, "markers" + (" (legacy layout)" if legacy else ""))
