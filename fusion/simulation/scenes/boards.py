"""Calibration boards, seen from many sides in infrared and colour."""

import numpy as np

from fusion.errors import SceneError
from fusion.geometry.pose import Array, pose
from fusion.simulation.scene.board import PaintedBoard, board_paint, board_plate
from fusion.simulation.scene.course import checked_frames, looking_at, standing
from fusion.simulation.scene.scene import Scene
from fusion.simulation.scenes.panel import WARM_S, upright

GOLDEN = np.pi * (3 - np.sqrt(5))  # [rad] spreads directions evenly, whatever their number
MOST_TILT = np.deg2rad(38.0)
ASPECT = 0.75  # height over width of the picture


def checkerboard(
    columns: int = 9, rows: int = 6, square_m: float = 0.04, field_deg: float = 56.0, frames: int = 20
) -> Scene:
    """a checkerboard (numbers of inner corners), each frame from another side; field_deg across"""
    return _seen("checkerboard", PaintedBoard(columns, rows, square_m), field_deg, frames)


def charuco(
    columns: int = 9,
    rows: int = 6,
    square_m: float = 0.04,
    marker_m: float = 0.03,
    dictionary: str = "DICT_5X5_100",
    field_deg: float = 56.0,
    frames: int = 20,
) -> Scene:
    """a ChArUco board (numbers of inner corners), each frame from another side; field_deg across"""
    return _seen("charuco", PaintedBoard(columns, rows, square_m, marker_m, dictionary), field_deg, frames)


def _seen(name: str, board: PaintedBoard, field_deg: float, frames: int) -> Scene:
    checked_frames(frames)
    if not 10 <= field_deg <= 120:
        raise SceneError("the field of view cannot be used", found=field_deg, expected="10 to 120 degrees")
    field = np.tan(np.deg2rad(field_deg) / 2) * np.array([1.0, ASPECT])
    # the board hangs in the plane x = 0 and faces +x: its x is the world's y, its y points down
    T_world_board = pose(np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.zeros(3))
    return Scene(
        name=name,
        parts=(board_plate(board, T_world_board), upright((-20.0, 20.0), (-10.0, 10.0), -0.6, 0.5)),
        course=standing(_views(board, field, frames), 1, frame_s=2.0, start_s=WARM_S),
        paints=(board_paint(board, T_world_board),),
        poses=None,
        ambient_lux=300.0,
        color=True,
        infrared=True,
        board=board,
    )


def _views(board: PaintedBoard, field: Array, frames: int) -> list[Array]:
    """Poses that tilt and roll the board and put it into all parts of the picture, always the whole of it."""
    half = 0.5 * np.array(board.size_m)
    nearest = 1.1 * float(max(half / field))
    views = []
    for k in range(frames):
        share = (k + 0.5) / frames
        tilt, around = MOST_TILT * np.sqrt(share), GOLDEN * k
        distance = nearest * (1.0 + 0.4 * ((k * 0.618) % 1.0)) + float(max(half)) * np.sin(tilt)
        out = np.array([np.cos(tilt), np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around)])
        roll = np.deg2rad(18.0) * np.sin(2.3 * k)
        # a rolled board reaches further up and down
        c, s = abs(np.cos(roll)), abs(np.sin(roll))
        reach = np.array([c * half[0] + s * half[1], s * half[0] + c * half[1]]) / (distance - max(half) * np.sin(tilt))
        room = np.maximum(field - 1.05 * reach, 0.0) * distance
        aside = room * np.array([np.cos(1.9 * k), np.sin(2.6 * k)])
        T = looking_at(distance * out, np.zeros(3), roll)
        views.append(pose(T[:3, :3], T[:3, 3] + T[:3, :2] @ aside))
    return views
