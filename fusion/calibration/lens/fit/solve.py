"""The camera that explains the views best, and what every view says about it."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from fusion.calibration.lens.fit.adjust import adjusted
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array

# in the order of OpenCV's distortion behind the camera matrix; a wide lens has the rational form's three more
NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
RATIONAL = (*NAMES, "k4", "k5", "k6")


@dataclass(frozen=True)
class LensSolution:
    """Least squares over all corners of some views."""

    parameters: Array  # (9,) in the order of NAMES, or (12,) in that of RATIONAL: [px] and OpenCV's distortion
    poses: Array  # (views, 6) rotation vector and translation [m] of the board in the camera
    residuals: list[Array]  # per view (n, 2) seen minus predicted [px]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return RATIONAL[: len(self.parameters)]

    @property
    def matrix(self) -> Array:
        """(3, 3) camera matrix [px]."""
        return matrix(self.parameters)

    @property
    def view_rms(self) -> Array:
        """(views,) root mean square distance [px] of the corners from their prediction."""
        return np.array([np.sqrt((r**2).sum(axis=1).mean()) for r in self.residuals])

    @property
    def rms(self) -> float:
        """Root mean square distance [px] over all corners, as OpenCV counts it."""
        return float(np.sqrt((np.concatenate(self.residuals) ** 2).sum(axis=1).mean()))

    def camera(self, size: tuple[int, int]) -> Camera:
        """The camera with these parameters; size is (width, height) [px]."""
        fx, fy, cx, cy, *distortion = map(float, self.parameters)
        return Camera(size[0], size[1], fx, fy, cx, cy, tuple(distortion))


def matrix(parameters: Array) -> Array:
    """(3, 3) camera matrix of parameters (9 or 12,)."""
    fx, fy, cx, cy = parameters[:4]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def solve(
    views: Sequence[BoardView],
    size: tuple[int, int],
    start: Array | None = None,
    hold_k3: bool = False,
    rational: bool = False,
) -> LensSolution:
    """Fit one camera and a pose per view.

    Args:
        views: at least three.
        start: parameters to start from; twelve of them are fitted in the rational form.
        hold_k3: leave k3 where `start` has it, or at 0.
        rational: fit all twelve parameters, from the best nine on where there is no `start`.

    Raises:
        RecordingError: too few views, or no camera explains them.
    """
    if len(views) < 3:
        do = "record 10 or more pictures with the board tilted in several directions"
        raise RecordingError("too few views of the board", found=len(views), expected="3 or more", do=do)
    try:
        begin = _guess(views, size) if start is None else np.array(start, float)
        if rational and len(begin) < len(RATIONAL):
            begin = np.concatenate([solve(views, size, begin).parameters, np.zeros(3)])
        free = np.array([name != "k3" or not hold_k3 for name in RATIONAL[: len(begin)]])
        found = [pose for view in views if (pose := placed(view, begin)) is not None]
        if len(found) < len(views):
            raise np.linalg.LinAlgError("a view without a pose")
        parameters, poses = adjusted(lambda n, *at: jacobian(views[n], *at), begin, np.array(found), free)
    except (cv2.error, np.linalg.LinAlgError) as error:
        do = "tilt the board in several directions, and check board.json"
        raise RecordingError("no camera explains the views", found=f"{len(views)} views", do=do) from error
    if not (np.isfinite(parameters).all() and np.isfinite(poses).all()):
        raise RecordingError(
            "no camera explains the views", found="a solution that is not finite", do="check the pictures"
        )
    return LensSolution(parameters, poses, [residual(v, p, parameters) for v, p in zip(views, poses, strict=True)])


def _guess(views: Sequence[BoardView], size: tuple[int, int]) -> Array:
    """Parameters (9,) of a camera without distortion, from what the board's squares look like."""
    points = [np.ascontiguousarray(view.points * [1, 1, 0], np.float32) for view in views]  # of a flat board
    pixels = [np.ascontiguousarray(view.pixels.reshape(-1, 1, 2), np.float32) for view in views]
    K = cv2.initCameraMatrix2D(points, pixels, size, 0)
    return np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0, 0, 0, 0, 0], float)


def residual(view: BoardView, pose: Array, parameters: Array) -> Array:
    """(n, 2) seen minus predicted [px] of a view with its pose (6,)."""
    predicted, _ = cv2.projectPoints(view.points, pose[:3], pose[3:], matrix(parameters), parameters[4:])
    return view.pixels - predicted.reshape(-1, 2)


def jacobian(view: BoardView, pose: Array, parameters: Array) -> tuple[Array, Array]:
    """(2n, parameters + 6) derivative of the predicted pixels in camera and pose, (2n,) predicted minus seen [px]."""
    predicted, J = cv2.projectPoints(view.points, pose[:3], pose[3:], matrix(parameters), parameters[4:])
    # OpenCV's columns: rotation, translation, focal length, principal point, distortion
    return np.hstack([J[:, 6 : 6 + len(parameters)], J[:, :6]]), (predicted.reshape(-1, 2) - view.pixels).ravel()


def placed(view: BoardView, parameters: Array) -> Array | None:
    """Pose (6,) of the board in a view for a known camera, or None."""
    try:
        # of the flat board first: without a start, OpenCV takes a board that bows for points all about in space
        flat = view.points * [1, 1, 0]
        ok, turn, shift = cv2.solvePnP(flat, view.pixels, matrix(parameters), parameters[4:])
        if ok and view.points[:, 2].any():
            seen = view.points, view.pixels, matrix(parameters), parameters[4:]
            ok, turn, shift = cv2.solvePnP(*seen, turn, shift, useExtrinsicGuess=True)
    except cv2.error:
        return None
    pose = np.concatenate([np.ravel(turn), np.ravel(shift)])
    return pose if ok and np.isfinite(pose).all() and pose[5] > 0 else None
