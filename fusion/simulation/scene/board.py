"""Calibration boards as pictures: checkerboards and ChArUco boards, from the fields of `board.json`."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board as CalibrationBoard
from fusion.calibration.lens.boards.board import knows_markers
from fusion.errors import SceneError
from fusion.geometry.pose import Array, transform
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.paint import Paint
from fusion.simulation.scene.scene import Part

SQUARE_PX = 120  # of a ChArUco board's picture: marker bits to 1 % of a square, corners exactly
MARGIN = 0.5  # [squares] of white around the board
MOST_SQUARES = 100


@dataclass(frozen=True)
class PaintedBoard(CalibrationBoard):
    """A board of black and white squares that can be drawn; its fields are those of a calibration's board."""

    columns: int = 9
    rows: int = 6
    square_m: float = 0.04

    def __post_init__(self) -> None:
        if not (2 <= self.columns < MOST_SQUARES and 2 <= self.rows < MOST_SQUARES):
            raise SceneError("the board has no such corners", found=f"{self.columns} x {self.rows}", expected="2 to 99")
        if not 1e-4 <= self.square_m <= 10:
            raise SceneError('"square_m" of the board cannot be used', found=self.square_m, expected="metres")
        if self.marker_m and not 0 < self.marker_m < self.square_m:
            raise SceneError('"marker_m" of the board cannot be used', found=self.marker_m, expected="below square_m")
        if self.marker_m and not knows_markers(self.dictionary):
            raise SceneError(
                '"dictionary" of the board is unknown', found=self.dictionary[:60], expected="DICT_5X5_100, ..."
            )

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height with the white margin [m]."""
        across, down = self.columns + 1 + 2 * MARGIN, self.rows + 1 + 2 * MARGIN
        return across * self.square_m, down * self.square_m

    def picture(self) -> NDArray[np.uint8]:
        """Grey image with the margin; the top-left square is black."""
        if not self.marker_m:
            squares = np.add.outer(np.arange(self.rows + 1), np.arange(self.columns + 1)) % 2
            picture, margin = np.kron(squares, np.full((2, 2), 255)), int(2 * MARGIN)
        else:
            shape = (self.columns + 1, self.rows + 1)
            markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
            try:
                board = cv2.aruco.CharucoBoard(shape, self.square_m, self.marker_m, markers)
                picture = board.generateImage((shape[0] * SQUARE_PX, shape[1] * SQUARE_PX), marginSize=0, borderBits=1)
            except cv2.error as error:
                found = f"{shape[0]} x {shape[1]} squares of {self.dictionary}"
                raise SceneError("OpenCV cannot draw this board", found=found, do="use a larger dictionary") from error
            margin = int(SQUARE_PX * MARGIN)
        return np.pad(picture, margin, constant_values=255).astype(np.uint8)


def board_paint(board: PaintedBoard, T_world_board: Array, turns: bool = False) -> Paint:
    """The board's pattern; `T_world_board` has its origin in the middle, x right, y down, z into the board."""
    corner = np.eye(4)
    corner[:2, 3] = -0.5 * np.array(board.size_m)
    return Paint(board.picture(), T_world_board @ corner, board.size_m, turns=turns)


def board_plate(board: PaintedBoard, T_world_board: Array, turns: bool = False) -> Part:
    """The flat plate that carries the pattern, with its mean reflectance."""
    x, y = 0.5 * np.array(board.size_m)
    corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    mesh = Mesh(transform(T_world_board, corners), np.array([[0, 2, 1], [0, 3, 2]], np.int32))
    grey = np.full((4, 3), int(board.picture().mean()), np.uint8)
    return Part(replace(mesh, colors=grey), reflectance=0.45, turns=turns)
