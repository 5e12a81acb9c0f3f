"""Boards as walls: the corners in the IR image tell where the board stands, so each picture is a wall of its own."""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.board_patches import patches, square_centres
from fusion.calibration.depth.walls.gloss import gloss_map, surfaces
from fusion.calibration.depth.walls.plane import WallPlane
from fusion.calibration.depth.walls.wall import Means, Wall, wall_of
from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.charuco import find_charuco
from fusion.calibration.lens.boards.detect import ATTEMPTS, DetectorTry, FoundCorners, find_checkerboard
from fusion.calibration.lens.fit.solve import placed
from fusion.calibration.lens.views import BoardView, view_of
from fusion.errors import FusionError, RecordingError
from fusion.geometry.camera import Camera, Principle
from fusion.progress import each
from fusion.recording.looking.sample import spread
from fusion.recording.recording import Frame, Recording
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import MODULATIONS_HZ

CORNER_PX = 0.05  # [px] a corner is never taken to be known better
WARPED = 0.002  # standard deviation of a tilt as the depth sees it: 0.2 mm over half a board of 20 cm (guess)
STEPS = 1e-6 * np.eye(6)
LOOKS = 8  # frames that tell whether a recording shows the board at all
FARTHEST = 0.1  # [m] off the board's plane: no brightness moves a depth that far, a lost phase does
Array = NDArray[np.floating]


def board_walls(recording: Recording, camera: Camera, known: Sensor, board: Board) -> list[Wall]:
    """One wall for each frame that shows the board in its IR (or colour) image; the others are left out.

    Raises:
        FusionError: depth says in most frames that the squares are of another size.
    """
    walls: list[Wall] = []
    elsewhere: list[float] = []  # depth over what the squares say
    if not _shows(recording, board):
        return walls
    for frame in each(recording, recording.path.name):
        name = f"{recording.path.name}/{frame.timestamp:.6f}"
        wall = _wall(frame, camera, known, board, name)
        walls += [wall] if isinstance(wall, Wall) else []
        elsewhere += [wall] if isinstance(wall, float) else []
    if not walls and 2 * len(elsewhere) > len(recording):
        by_depth = f"the board's squares measure {1e3 * board.square_m * np.median(elsewhere):.3g} mm by depth"
        found = f"in {len(elsewhere)} of {len(recording)} pictures, as the middle one has it"
        what = f"{by_depth}, {1e3 * board.square_m:.3g} mm in board.json"
        do = "measure a square with a ruler, check square_m and the depth unit"
        raise RecordingError(what, recording.path, found, "the same by both", do)
    return walls


def _shows(recording: Recording, board: Board) -> bool:
    """True when one of some frames shows the board: a hundred frames of a wall are not searched one by one."""
    if len(recording) <= LOOKS:
        return True
    some = [recording[index] for index in spread(len(recording), LOOKS)]
    if any(_corners(frame, board, ATTEMPTS[:1]) is not None for frame in some):
        return True
    return _corners(some[len(some) // 2], board, ATTEMPTS) is not None


def _corners(frame: Frame, board: Board, attempts: tuple[DetectorTry, ...] = ATTEMPTS) -> FoundCorners | None:
    picture = frame.ir if frame.ir is not None else frame.color
    if picture is None:
        return None
    return find_charuco(picture, board) if board.is_charuco else find_checkerboard(picture, board, attempts)


class SeenBoard(NamedTuple):
    """A board in an image."""

    board: Board
    view: BoardView
    pose: Array  # (6,) turn and shift of the board to the camera


def seen_board(frame: Frame, camera: Camera, board: Board) -> SeenBoard | None:
    """Corners of the board in the frame's IR (or colour) image, and the board's pose (6,); None when it is not seen."""
    found = _corners(frame, board)
    if found is None:
        return None
    view = view_of("", found.pixels, board, found.ids)
    pose = placed(view, np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion]))
    return None if pose is None else SeenBoard(board, view, pose)


def _wall(frame: Frame, camera: Camera, known: Sensor, board: Board, name: str) -> Wall | float | None:
    """The board as a wall; where depth has it elsewhere than its squares, its depth over theirs."""
    seen = seen_board(frame, camera, board)
    if seen is None:
        return None
    _, view, pose = seen
    mask = np.zeros(camera.shape, np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(np.rint(view.pixels).astype(np.int32)), 1)
    # one frame is noisy, and a power of a noisy brightness is biased
    depth = np.where(mask > 0, middle_of_nine(frame.depth), np.nan).astype(float)
    if np.isfinite(depth).sum() < 100:
        return None
    centre, distance, deviation = centre_depth(view, pose, camera)
    ir = None if frame.ir is None else middle_of_nine(frame.ir)
    means = Means(1, depth, np.full(camera.shape, np.nan), ir)
    moment = Moment(time=frame.timestamp)
    try:
        wall = wall_of(means, camera, known, (name, distance, deviation), moment, centre)
    except FusionError:  # a hand before the board, a reflection: one picture of many
        try:
            return wall_of(means, camera, known, (name, float("nan"), deviation), moment, centre).depth_there / distance
        except FusionError:
            return None
    wall = wall if board.is_charuco else _in_squares(wall, patches(board, pose, camera), camera)
    if known.principle == Principle.TIME_OF_FLIGHT:
        wall = _with_gloss(wall, frame, camera, seen, known.frequencies or MODULATIONS_HZ)
    return _as_the_board_stands(wall, pose, pose_covariance(view, pose, camera))


def middle_of_nine(image: NDArray) -> Array:
    """Median (h, w) over 3 x 3 px of an image (h, w), of what is known; NaN where a pixel itself is missing."""
    image = np.asarray(image, float)
    wide = np.pad(image, 1, mode="edge")
    height, width = image.shape
    nine = np.stack([wide[v : v + height, u : u + width] for v in range(3) for u in range(3)])
    known = np.isfinite(image)
    out = np.full(image.shape, np.nan)
    out[known] = np.nanmedian(nine[:, known], axis=0)
    return out


def _in_squares(wall: Wall, squares: NDArray[np.intp] | None, camera: Camera) -> Wall:
    """The wall as one number for each square; dark ones are part of it, as far as their brightness can move them."""
    if squares is None:
        return wall
    with np.errstate(invalid="ignore"):
        near = np.abs(wall.depth - wall.plane.depth(camera)) < FARTHEST
    return replace(wall, mask=(squares >= 0) & near, squares=squares)


def _with_gloss(wall: Wall, frame: Frame, camera: Camera, stands: SeenBoard, frequencies: tuple[float, ...]) -> Wall:
    """The wall with what its squares mirror; `frequencies`: modulations [Hz]."""
    if wall.squares is None or wall.ir is None or frame.ir is None:
        return wall
    board, _, pose = stands
    turned = cv2.Rodrigues(pose[:3])[0]
    middles = np.asarray(square_centres(board) @ turned.T + pose[3:], float)
    normal = np.asarray(turned[:, 2], float)
    seen = surfaces(frame.depth, frame.ir, camera)
    return replace(wall, gloss=gloss_map(wall.squares, (middles, normal), wall.ir, seen, frequencies))


def centre_depth(view: BoardView, pose: Array, camera: Camera) -> tuple[tuple[float, float], float, float]:
    """Ray (x, y) to the middle of the corners seen, the depth of the board there, and its standard deviation [m]."""
    middle = view.points.mean(axis=0)
    gradient = np.array([(_at(pose + step, middle)[2] - _at(pose - step, middle)[2]) / 2e-6 for step in STEPS])
    x, y, z = _at(pose, middle)
    variance = gradient @ pose_covariance(view, pose, camera) @ gradient
    return (float(x / z), float(y / z)), float(z), float(np.sqrt(variance))


def pose_covariance(view: BoardView, pose: Array, camera: Camera) -> Array:
    """(6, 6) of a board's pose, from what its corners leave over."""
    K, lens = camera.matrix, np.array(camera.distortion)
    pixels, jacobian = cv2.projectPoints(view.points, pose[:3], pose[3:], K, lens)
    rest = view.pixels - pixels.reshape(-1, 2)
    freedom = max(rest.size - 6, 1)
    sigma = max(float(np.sqrt((rest**2).sum() / freedom)), CORNER_PX)
    return np.asarray(sigma**2 * np.linalg.pinv(jacobian[:, :6].T @ jacobian[:, :6]), float)


def _as_the_board_stands(wall: Wall, pose: Array, covariance: Array) -> Wall:
    """The wall with the tilts of the board, at the distance that the depth image gives it."""
    a, b = _tilts(pose)
    slopes = np.array([(_tilts(pose + step) - _tilts(pose - step)) / 2e-6 for step in STEPS])
    std = float(np.sqrt(np.diag(slopes.T @ covariance @ slopes).max()))
    seen = wall.plane.distance / wall.plane.inverse_at(*wall.centre)
    upright = WallPlane(1.0, float(a), float(b))
    plane = replace(upright, distance=seen * upright.inverse_at(*wall.centre))
    return replace(wall, plane=plane, tilt_std=float(np.hypot(std, WARPED)))


def _tilts(pose: Array) -> Array:
    """a, b (2,) of the board's plane 1 / z = (1 + a x + b y) / D."""
    normal = cv2.Rodrigues(pose[:3])[0][:, 2]
    return np.asarray(normal[:2] / normal[2], float)


def _at(pose: Array, point: Array) -> Array:
    """A point of the board in the camera frame (3,)."""
    return cv2.Rodrigues(pose[:3])[0] @ point + pose[3:]
