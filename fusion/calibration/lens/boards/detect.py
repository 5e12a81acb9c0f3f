"""The corners of a checkerboard in one picture, speckled and dim ones too.

Several attempts, the quickest first; whatever finds the board, the corners are then refined in the picture itself, at
its own size. Measured with tools/reproduce/calibration/boards.py: the classic detector needs a twentieth of the time of
the sector-based one and finds more boards as soon as small ones are enlarged.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.grid import implausible, upright
from fusion.calibration.lens.boards.refine import counts, refined
from fusion.geometry.pose import Array

FEWEST_PX = 3  # a square of fewer pixels has no corners to find
LARGEST_SEARCH = 1600  # [px] longer pictures are searched in a smaller copy
CLASSIC = cv2.CALIB_CB_ADAPTIVE_THRESH
EQUALISED = CLASSIC | cv2.CALIB_CB_NORMALIZE_IMAGE  # helps in even light, hurts in front of black
SECTORS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE

Grey = NDArray[np.uint8]


@dataclass(frozen=True)
class DetectorTry:
    """One way to look for the board: enlarged by `scale`, smoothed by `blur` [px], with one of OpenCV's detectors."""

    detector: str
    scale: int = 1
    blur: float = 0.0

    @property
    def name(self) -> str:
        """The way in words, for reports."""
        return self.detector + (f" x{self.scale}" if self.scale > 1 else "") + (" smoothed" if self.blur else "")


# in the order of their time; each finds boards that those before miss
ATTEMPTS = (
    DetectorTry("equalised"),
    DetectorTry("classic", 2),
    DetectorTry("classic", 3, 0.6),
    DetectorTry("equalised", 2, 1.0),
    DetectorTry("sectors"),
)


@dataclass(frozen=True)
class FoundCorners:
    """The corners found in a picture."""

    ids: NDArray[np.intp]  # (n,) index of each corner, row by row over the board
    pixels: Array  # (n, 2) [px], the centre of the top-left pixel is (0, 0)
    how: str  # which attempt found them


def stretched(image: NDArray) -> Grey:
    """8-bit picture whose contrast fills the range: counts of any size (height, width[, 3]), not finite ones dark."""
    values: Any = counts(image)
    low, high = np.percentile(values[:: max(values.shape[0] // 400, 1)], [1, 99])
    if not high > low:
        low, high = float(values.min()), float(values.max())
    if not high > low:
        return np.zeros(values.shape, np.uint8)
    return (np.clip((values - low) / (high - low), 0, 1) * 255).astype(np.uint8)


def find_checkerboard(
    image: NDArray, board: Board, attempts: tuple[DetectorTry, ...] = ATTEMPTS
) -> FoundCorners | None:
    """All corners of the board in a picture of any depth of grey (or colour), or None.

    Args:
        board: what to look for; half a board is not found.
        attempts: tried in this order; the first whose corners form a board wins.
    """
    grey = stretched(image)
    if min(grey.shape) < 4 * FEWEST_PX or not grey.any():
        return None
    for attempt in attempts:
        pixels = _attempt(grey, board, attempt)
        if pixels is None:
            continue
        pixels = upright(refined(image, pixels, board), board)
        if not implausible(pixels, board, grey.shape):
            return FoundCorners(np.arange(board.corners), pixels, attempt.name)
    return None


def _attempt(grey: Grey, board: Board, attempt: DetectorTry) -> Array | None:
    """(n, 2) corners [px] of the picture at its own size, before refinement."""
    scale = attempt.scale * min(1.0, LARGEST_SEARCH / max(grey.shape))
    if attempt.scale > 1 and max(grey.shape) * scale > 2 * LARGEST_SEARCH:
        return None  # enlarging is for small pictures
    picture: Any = cv2.GaussianBlur(grey, (0, 0), attempt.blur) if attempt.blur else grey
    if scale != 1:
        how = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=how)
    size = (board.columns, board.rows)
    try:
        ok, corners = DETECTORS[attempt.detector](picture, size)
    except cv2.error:  # some versions raise on pictures without any structure
        return None
    if not ok or corners is None or len(corners) != board.corners:
        return None
    # resizing keeps the outer edges of the pixels, not their centres, in place
    return (corners.reshape(-1, 2).astype(float) + 0.5) / scale - 0.5


DETECTORS: dict[str, Callable[[Grey, tuple[int, int]], tuple[bool, NDArray]]] = {
    "classic": lambda picture, size: cv2.findChessboardCorners(picture, size, flags=CLASSIC),
    "equalised": lambda picture, size: cv2.findChessboardCorners(picture, size, flags=EQUALISED),
    "sectors": lambda picture, size: cv2.findChessboardCornersSB(picture, size, flags=SECTORS),
}


def largest_board(image: NDArray) -> tuple[int, int] | None:
    """(columns, rows) of the largest checkerboard in a picture, whatever its size; None where there is none."""
    grey = stretched(image)
    for scale in (1.0, 2.0):
        # small squares are missed at their own size; squares of a large picture need no enlarging
        scale = min(scale, LARGEST_SEARCH / max(grey.shape))
        how = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
        picture = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_LARGER
        try:
            ok, corners, meta = cv2.findChessboardCornersSBWithMeta(picture, (3, 3), flags=flags)
        except cv2.error:
            return None
        if not ok or meta is None or meta.size <= 9:  # three by three is found in much that is no board
            continue
        board = Board(int(meta.shape[1]), int(meta.shape[0]), 1.0)
        pixels = (corners.reshape(-1, 2).astype(float) + 0.5) / scale - 0.5
        if not implausible(refined(image, pixels, board), board, grey.shape):  # four by three in many a room
            return board.columns, board.rows
    return None
