"""Where the colour camera stands beside the depth camera, from pictures of one board by both."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from fusion.calibration.lens.fit.solve import placed
from fusion.calibration.lens.views import BoardView, common
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array

FEWEST_CORNERS = 6
FAR = (
    5.0  # robust standard deviations: a pair that says something else (a board counted from its other end, a moved rig)
)
# [deg], [m]: differences below are no reason to drop a pair; absolute, of a rig's screws and a hand
LEAST = (0.5, 0.01)


@dataclass(frozen=True)
class CameraPair:
    """Two cameras side by side."""

    T_color_depth: Array  # (4, 4) maps points of the depth camera to the colour camera
    std_rotation: Array  # (3,) [rad] about x, y, z
    std_translation: Array  # (3,) [m]
    rms_px: float  # over the corners of both
    used: list[str]  # names of the pairs
    left_out: list[str]  # names of pairs that say something else


def place_color(
    ir: Sequence[BoardView], color: Sequence[BoardView], ir_camera: Camera, color_camera: Camera
) -> CameraPair:
    """Relative pose with both cameras' intrinsics held.

    Args:
        ir, color: views; those of the same name belong together.
        ir_camera, color_camera: of their fits.

    Raises:
        RecordingError: fewer than three pairs that agree.
    """
    by_name = {view.name: view for view in color}
    pairs = [common(view, by_name[view.name]) for view in ir if view.name in by_name]
    pairs = [pair for pair in pairs if len(pair[0]) >= FEWEST_CORNERS]
    relative = [_relative(*pair, ir_camera, color_camera) for pair in pairs]
    known = [i for i, pose in enumerate(relative) if pose is not None]
    poses = np.array([relative[i] for i in known])
    if len(known) < 3:
        raise _too_few(len(known))
    near = _agreeing(poses)
    if near.sum() < 3:
        raise _too_few(int(near.sum()))
    used = [pairs[i] for i, good in zip(known, near, strict=True) if good]
    points = [np.ascontiguousarray(one.points, np.float32) for one, _ in used]
    seen = [
        [np.ascontiguousarray(v.pixels, np.float32).reshape(-1, 1, 2) for v in side] for side in zip(*used, strict=True)
    ]
    lens = [np.array(camera.distortion) for camera in (ir_camera, color_camera)]
    size = (ir_camera.width, ir_camera.height)
    place: Any = cv2.stereoCalibrate  # its types ask for start values that the flags make needless
    rms, *_, R, t, _, _ = place(
        points, *seen, ir_camera.matrix, lens[0], color_camera.matrix, lens[1], size, flags=cv2.CALIB_FIX_INTRINSIC
    )
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, np.ravel(t)
    scatter = poses[near].std(axis=0, ddof=1) / np.sqrt(near.sum())
    names = [pairs[i][0].name for i in known]
    return CameraPair(
        T, scatter[:3], scatter[3:], float(rms),
        [n for n, good in zip(names, near, strict=True) if good],
        [n for n, good in zip(names, near, strict=True) if not good],
    )  # fmt: skip


def _relative(ir: BoardView, color: BoardView, ir_camera: Camera, color_camera: Camera) -> Array | None:
    """(6,) rotation vector and translation of the colour camera as one pair tells it."""
    poses: Any = [
        placed(view, np.array([c.fx, c.fy, c.cx, c.cy, *c.distortion]))
        for view, c in ((ir, ir_camera), (color, color_camera))
    ]
    if poses[0] is None or poses[1] is None:
        return None
    (R_ir, t_ir), (R_color, t_color) = ((cv2.Rodrigues(p[:3])[0], p[3:]) for p in poses)
    R = R_color @ R_ir.T
    return np.concatenate([cv2.Rodrigues(R)[0].ravel(), t_color - R @ t_ir])


def _agreeing(poses: Array) -> Array:
    """(n,) True for relative poses (n, 6) near the middle one."""
    distance = np.abs(poses - np.median(poses, axis=0))
    turned = np.degrees(np.linalg.norm(distance[:, :3], axis=1))
    moved = np.linalg.norm(distance[:, 3:], axis=1)
    return (turned <= max(FAR * np.median(turned), LEAST[0])) & (moved <= max(FAR * np.median(moved), LEAST[1]))


def _too_few(found: int) -> RecordingError:
    do = "record pairs in which both cameras see the whole board"
    return RecordingError("too few pairs place the colour camera", found=found, expected="3 that agree", do=do)
