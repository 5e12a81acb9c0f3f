"""`board.json`: what the board is, and whether that can be."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
from msgspec import Meta, Struct

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.files.json_file import read_json
from fusion.geometry.pose import Array

CORNERS = "INNER corners, one less than there are squares"
SIDE = "side of a square [m]"
# OpenCV's detectors want 3; more than 60 do not fit 4000 px
Count = Annotated[float, Meta(ge=3, le=60, multiple_of=1, description=CORNERS)]
# a camera calibration can use
Side = Annotated[float, Meta(ge=0.002, le=0.5, description=SIDE)]
Marker = Annotated[float, Meta(ge=0, le=10, description="side of a marker [m]; absent or 0: a checkerboard")]
Dictionary = Annotated[str, Meta(description="OpenCV's name of the markers, such as DICT_5X5_100")]
CHARUCO = (
    'a ChArUco board has "marker_m" [m] and "dictionary" beside "columns", "rows", "square_m"; a checkerboard neither'
)
ONE_PITCH = ("square_x_m", "square_y_m", "square_width_m", "square_height_m")


class DrawnBoard(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A board that can be drawn; calibration wants more of it."""

    columns: Annotated[float, Meta(ge=2, le=99, multiple_of=1, description=CORNERS)]
    rows: Annotated[float, Meta(ge=2, le=99, multiple_of=1, description=CORNERS)]
    square_m: Annotated[float, Meta(ge=1e-4, le=10, description=SIDE)]
    marker_m: Marker | None = None
    dictionary: Dictionary | None = None


class BoardFile(DrawnBoard, frozen=True, kw_only=True):
    """A calibration board: `board.json`."""

    columns: Count
    rows: Count
    square_m: Side


@dataclass(frozen=True)
class Board:
    """A board of black and white squares, all of one size."""

    # columns, rows: numbers of inner corners
    columns: int
    rows: int
    square_m: float  # side of a square [m]
    marker_m: float = 0.0  # side of a marker [m] of a ChArUco board; 0 for a checkerboard
    dictionary: str = ""  # OpenCV's name of its markers, such as "DICT_5X5_100"

    @property
    def is_charuco(self) -> bool:
        """True where the squares hold markers."""
        return self.marker_m > 0

    @property
    def corners(self) -> int:
        """How many inner corners there are."""
        return self.columns * self.rows

    def points(self) -> Array:
        """(columns * rows, 3) corners [m], row by row, z 0; x along a row, y along a column."""
        v, u = np.mgrid[0 : self.rows, 0 : self.columns]
        return np.stack([u.ravel(), v.ravel(), np.zeros(u.size)], axis=1) * self.square_m

    def file(self) -> BoardFile:
        """The content of `board.json`."""
        marker, dictionary = (self.marker_m, self.dictionary) if self.is_charuco else (None, None)
        return BoardFile(
            columns=self.columns, rows=self.rows, square_m=self.square_m, marker_m=marker, dictionary=dictionary
        )


def read_board(path: Path | str) -> Board:
    """The board of a `board.json`. Raises RecordingError.

    >>> fusion.read_board("board/board.json").square_m
    0.04
    """
    return board_of(Content(read_json(path, RecordingError, "the board file"), path, "the board", RecordingError))


def board_of(content: Content) -> Board:
    """A board that can be.

    Raises:
        RecordingError: a field is absent or no number, there are too few corners, the squares are not all of one
            size, a length looks like millimetres, or the markers are not known to OpenCV.
    """
    uneven = [name for name in ONE_PITCH if name in content.value]
    if uneven or isinstance(content.value.get("square_m"), list):
        must = "one side for all squares: rows and columns must have the same pitch"
        raise content.wrong(BoardFile, (uneven or ["square_m"])[0], expected=must)
    given = content.as_type(BoardFile)
    board = Board(int(given.columns), int(given.rows), given.square_m)
    if not given.marker_m and not given.dictionary:
        return board
    return _charuco(board, given, replace(content, do=CHARUCO))


def knows_markers(dictionary: str) -> bool:
    """True for OpenCV's name of a set of markers, such as DICT_5X5_100."""
    return dictionary.startswith("DICT_") and hasattr(cv2.aruco, dictionary)


def _charuco(board: Board, given: BoardFile, content: Content) -> Board:
    """The board with its markers, which must fit into the squares and be known."""
    name = given.dictionary or ""
    if not given.marker_m:
        raise content.wrong(BoardFile, "marker_m")
    if given.marker_m >= board.square_m:
        raise content.wrong(BoardFile, "marker_m", expected=f"less than the squares' {board.square_m:g} m")
    if not knows_markers(name):
        raise content.wrong(BoardFile, "dictionary")
    known = len(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name)).bytesList)
    needed = (board.columns + 1) * (board.rows + 1) // 2
    if needed > known:
        found, must = f"{name} with {known} markers", f"at least {needed}, one for every second square"
        raise content.wrong(BoardFile, "dictionary", found=found, expected=must)
    return replace(board, marker_m=given.marker_m, dictionary=name)
