"""Boards as a camera with a known lens would see them: corners, and pictures with blur, speckle and little light."""

import cv2
import numpy as np

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.fit.solve import matrix
from fusion.calibration.lens.views import BoardView, view_of

SIZE = (512, 424)
# a Kinect v2's infrared camera, about
TRUTH = np.array([366.0, 367.0, 258.0, 207.0, 0.09, -0.26, 0.001, -0.002, 0.09])
SQUARE_PX = 40
MARGIN = 0.5  # squares of white around the board


def poses(count: int, seed: int = 0, board: Board | None = None) -> np.ndarray:
    """(count, 6) poses of the board, all of it in the picture, tilted by about 25 degrees."""
    board = board or Board(9, 6, 0.04)
    rng = np.random.default_rng(seed)
    middle = board.points().mean(axis=0)
    found: list[np.ndarray] = []
    while len(found) < count:
        turn = rng.normal(0, 0.35, 3)
        place = np.array([rng.uniform(-0.35, 0.35), rng.uniform(-0.3, 0.3), rng.uniform(0.6, 1.1)])
        pose = np.concatenate([turn, place - cv2.Rodrigues(turn)[0] @ middle])
        pixels = project(board.points(), pose)
        if (pixels > 20).all() and (pixels < np.array(SIZE) - 20).all():
            found.append(pose)
    return np.array(found)


def project(points: np.ndarray, pose: np.ndarray, truth: np.ndarray = TRUTH) -> np.ndarray:
    """(n, 2) pixels of points (n, 3) of the board."""
    pixels, _ = cv2.projectPoints(points, pose[:3], pose[3:], matrix(truth), truth[4:])
    return pixels.reshape(-1, 2)


def views(count: int, sigma_px: float, seed: int = 0, board: Board | None = None) -> list[BoardView]:
    """Views with normal noise of each coordinate; what the calibration believes is `board`, what is true as well."""
    board = board or Board(9, 6, 0.04)
    rng = np.random.default_rng(seed + 1000)
    exact = [project(board.points(), pose) for pose in poses(count, seed, board)]
    return [
        view_of(f"{i:02d}", pixels + rng.normal(0, sigma_px, pixels.shape), board) for i, pixels in enumerate(exact)
    ]


def pattern(board: Board) -> np.ndarray:
    """(h, w) picture of the board from the front, SQUARE_PX a square, with its margin."""
    squares = np.add.outer(np.arange(board.rows + 1), np.arange(board.columns + 1)) % 2
    picture = np.kron(squares, np.full((SQUARE_PX, SQUARE_PX), 230)).astype(np.float32) + 20
    if board.is_charuco:
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
        shape = (board.columns + 1, board.rows + 1)
        layout = cv2.aruco.CharucoBoard(shape, board.square_m, board.marker_m, markers)
        picture = layout.generateImage((shape[0] * SQUARE_PX, shape[1] * SQUARE_PX)).astype(np.float32)
    return np.pad(picture, int(MARGIN * SQUARE_PX), constant_values=250)


def picture(board: Board, pose: np.ndarray, truth: np.ndarray = TRUTH, seed: int = 0, light: float = 1.0) -> np.ndarray:
    """(h, w) uint16 infrared counts: the board through the true lens, four rays a pixel, light falling off, speckle."""
    fine = 2
    out = 1 + MARGIN
    edge = np.array([[x, y] for x in (-out, board.columns - 1 + out) for y in (-out, board.rows - 1 + out)])
    box = project(np.hstack([edge * board.square_m, np.zeros((4, 1))]), pose, truth)
    (left, top), (right, bottom) = box.min(axis=0).clip(0).astype(int), (box.max(axis=0) + 2).clip(0, SIZE).astype(int)
    v, u = np.mgrid[top * fine : bottom * fine, left * fine : right * fine]
    pixels = np.stack([(u + 0.5) / fine - 0.5, (v + 0.5) / fine - 0.5], axis=2).reshape(-1, 1, 2).astype(float)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 12, 1e-6)  # a third of the error is left each time
    xy = cv2.undistortPoints(pixels, matrix(truth), truth[4:], criteria=criteria).reshape(-1, 2)
    R, _ = cv2.Rodrigues(pose[:3])
    rays = np.hstack([xy, np.ones((len(xy), 1))])
    depth = (R[:, 2] @ pose[3:]) / (rays @ R[:, 2])
    on_board = (rays * depth[:, None] - pose[3:]) @ R
    # corner (0, 0) lies one square and the margin inside of the picture's outer edge
    at = (on_board[:, :2] / board.square_m + 1 + MARGIN) * SQUARE_PX - 0.5
    maps = [at[:, i].reshape(u.shape).astype(np.float32) for i in (0, 1)]
    part = cv2.remap(pattern(board), maps[0], maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=5)
    seen = np.full(SIZE[::-1], 5, np.float32)
    seen[top:bottom, left:right] = cv2.resize(part, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    seen = cv2.GaussianBlur(seen, (0, 0), 0.6)
    rng = np.random.default_rng(seed)
    falloff = np.hypot(*np.meshgrid(np.linspace(-1, 1, SIZE[0]), np.linspace(-1, 1, SIZE[1])))
    counts = light * 60 * seen * (1 - 0.5 * falloff**2)
    counts = counts * rng.gamma(200, 1 / 200, counts.shape) + rng.normal(0, 30, counts.shape)
    return np.clip(counts, 0, 65535).astype(np.uint16)
