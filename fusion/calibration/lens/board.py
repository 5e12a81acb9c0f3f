"""`board.json`: what the board is, and whether that can be."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.recording.text_files import read_json

FEWEST, MOST = 3, 60  # inner corners a side: OpenCV's detectors want 3; more than 60 do not fit 4000 px
SMALLEST_M, LARGEST_M = 0.002, 0.5  # sides of squares that a camera calibration can use
CHARUCO = (
    'a ChArUco board has "marker_m" [m] and "dictionary" beside "columns", "rows", "square_m"; a checkerboard neither'
)
ONE_PITCH = ("square_x_m", "square_y_m", "square_width_m", "square_height_m")


@dataclass(frozen=True)
class Board:
    """A board of black and white squares, all of one size.

    Attributes:
        columns, rows: numbers of inner corners.
        square_m: side of a square [m].
        marker_m: side of a marker [m] of a ChArUco board; 0 for a checkerboard.
        dictionary: OpenCV's name of its markers, such as "DICT_5X5_100".
    """

    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0
    dictionary: str = ""

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

    def to_dict(self) -> dict[str, Any]:
        """The content of `board.json`."""
        fields = {"columns": self.columns, "rows": self.rows, "square_m": self.square_m}
        return fields | ({"marker_m": self.marker_m, "dictionary": self.dictionary} if self.is_charuco else {})


def read_board(path: Path | str) -> Board:
    """The board of a `board.json`. Raises RecordingError.

    >>> fusion.read_board("board/board.json").square_m
    0.04
    """
    return board_from_dict(read_json(Path(path)), Path(path))


def board_from_dict(fields: dict[str, Any], where: object = "board.json") -> Board:
    """A board that can be; `where` names it in errors.

    Raises:
        RecordingError: a field is absent or no number, there are too few corners, the squares are not all of one
            size, a length looks like millimetres, or the markers are not known to OpenCV.
    """
    uneven = [name for name in ONE_PITCH if name in fields]
    if uneven or isinstance(fields.get("square_m"), list):
        found = ", ".join(uneven) or repr(fields["square_m"])
        raise _wrong("square_m", where, found, "one side for all squares: rows and columns must have the same pitch")
    columns, rows = _count(fields, "columns", where), _count(fields, "rows", where)
    square = _length(fields, "square_m", where)
    if not fields.get("marker_m") and not fields.get("dictionary"):
        return Board(columns, rows, square)
    marker, name = _length(fields, "marker_m", where), str(fields.get("dictionary", "nothing"))
    if marker >= square:
        raise _wrong("marker_m", where, f"{marker:g} m in squares of {square:g} m", "markers smaller than the squares")
    if not (name.startswith("DICT_") and hasattr(cv2.aruco, name)):
        raise _wrong("dictionary", where, name, "OpenCV's name of the markers, such as DICT_5X5_100")
    known = len(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name)).bytesList)
    if (columns + 1) * (rows + 1) // 2 > known:
        expected = f"at least {(columns + 1) * (rows + 1) // 2}, one for every second square"
        raise _wrong("dictionary", where, f"{name} with {known} markers", expected)
    return Board(columns, rows, square, marker, name)


def _count(fields: dict[str, Any], name: str, where: object) -> int:
    value: Any = fields.get(name)
    found = repr(value) if name in fields else "nothing"
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value or value not in range(MOST + 1):
        raise _wrong(name, where, found, f"a whole number of INNER corners, {FEWEST} to {MOST}")
    if value < FEWEST:
        raise _wrong(name, where, found, f"{FEWEST} inner corners or more (one less than there are squares)")
    return int(value)


def _length(fields: dict[str, Any], name: str, where: object) -> float:
    value: Any = fields.get(name)
    found = repr(value) if name in fields else "nothing"
    usable = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
    if not usable or not math.isfinite(value) or value <= 0:
        raise _wrong(name, where, found, "metres, above 0")
    if value > LARGEST_M:
        expected = f"metres, up to {LARGEST_M:g}"
        hint = f"; {value:g} looks like millimetres: write {value / 1000:g}" if value <= 1000 * LARGEST_M else ""
        raise _wrong(name, where, found, expected + hint)
    if value < SMALLEST_M:
        raise _wrong(name, where, found, f"metres, {SMALLEST_M:g} or more")
    return float(value)


def _wrong(name: str, where: object, found: object, expected: str) -> RecordingError:
    do = CHARUCO if name in ("marker_m", "dictionary") else ""
    return RecordingError(f'"{name}" of the board cannot be right', where, str(found)[:80], expected, do)
