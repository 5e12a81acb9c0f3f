"""Whether the stated size of the squares agrees with the depth that was recorded with the pictures."""

from pathlib import Path

import cv2
import numpy as np

from fusion.calibration.lens.fit.outliers import JudgedViews
from fusion.calibration.lens.fit.solve import LensSolution
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording

ASKED = 8  # views whose depth is read
APART = 0.08  # share: an uncalibrated depth camera is wrong by 2 to 4 %, a wrong square by 20
SAME_TIME = 0.02  # [s]


def size_warnings(path: Path, judged: JudgedViews) -> list[str]:
    """A sentence when the board's distance by its squares is not the depth that was measured; else nothing."""
    if path.is_dir() and not (path / "depth.txt").is_file():
        return []
    own = path.is_file() or (path / "camera.json").is_file()
    try:
        recording = open_recording(path, None if own else judged.solution.camera((1, 1)))
        asked = np.unique(np.linspace(0, len(judged.views) - 1, ASKED).astype(int))
        ratios = [_ratio(recording, judged.views[i], judged.solution, i) for i in asked]
    except RecordingError:  # depth that cannot be read takes nothing away from the pictures
        return []
    known = np.array([ratio for ratio in ratios if np.isfinite(ratio)])
    if len(known) < 3 or abs(np.median(known) - 1) < APART:
        return []
    ratio = float(np.median(known))
    return [
        f"the depth says that the board is {ratio:.2f} times as far away as its squares say: "
        f"check square_m (or the depth's unit)"
    ]


def _ratio(recording: Recording, view: BoardView, solution: LensSolution, place: int) -> float:
    """Measured over predicted depth at the corners of a view; NaN where there is no depth of the same moment."""
    try:
        stamp = float(view.name)
    except ValueError:
        return float("nan")
    index = int(np.argmin(np.abs(recording.timestamps - stamp)))
    if abs(recording.timestamps[index] - stamp) > SAME_TIME:
        return float("nan")
    frame = recording[index]
    pixels = np.round(view.pixels).astype(int)
    inside = ((pixels >= 0) & (pixels < np.array(frame.depth.shape[::-1]))).all(axis=1)
    if frame.ir is None or not inside.all():
        return float("nan")
    measured = frame.depth[pixels[:, 1], pixels[:, 0]]
    predicted = _depths(view.points, solution.poses[place])
    seen = np.isfinite(measured)
    return float(np.median(measured[seen] / predicted[seen])) if seen.sum() >= 6 else float("nan")


def _depths(points: Array, pose: Array) -> Array:
    """(n,) z [m] of the board's points (n, 3) in the camera."""
    R, _ = cv2.Rodrigues(pose[:3])
    return np.asarray(points @ R[2] + pose[5], float)
