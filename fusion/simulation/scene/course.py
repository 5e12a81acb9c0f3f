"""Course: where the camera stands at each frame, and how the table below the object turns."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SceneError
from fusion.geometry.pose import Array, pose
from fusion.recording.native.scene_file import MOST_FRAMES
from fusion.simulation.scene.turntable import Turntable

FARTHEST = 1e5  # [m] single precision resolves 1 cm there


@dataclass(frozen=True)
class SimulatedCourse:
    """Frames in time."""

    timestamps: NDArray[np.float64]  # (n,) since the sensor was switched on [s]
    T_world_camera: Array  # (n, 4, 4) true poses of the camera
    turntable: Turntable | None = None  # how the turning parts turn; None when nothing does
    continuous: bool = False  # camera and table move while a frame is taken; else they stop for each

    def __post_init__(self) -> None:
        n = len(self.timestamps)
        if not 1 <= n <= MOST_FRAMES:
            raise SceneError("the number of frames cannot be used", found=n, expected=f"1 to {MOST_FRAMES}")
        if self.T_world_camera.shape != (n, 4, 4) or not np.isfinite(self.T_world_camera).all():
            raise SceneError("a camera pose is not finite or absent", expected=f"{n} poses")
        if np.abs(self.T_world_camera).max() > FARTHEST:
            raise SceneError("a camera pose is out of bounds", expected=f"up to {FARTHEST:g} m", do="check the unit")
        if not np.isfinite(self.timestamps).all() or (np.diff(self.timestamps) <= 0).any():
            raise SceneError("the frames' time stamps do not grow", do="sort the trajectory, and take out doubles")
        if self.turntable is not None and self.turntable.frames != n:
            raise SceneError("table and camera have different frames", found=self.turntable.frames, expected=n)

    def __len__(self) -> int:
        return len(self.timestamps)


def standing(
    T_world_camera: Sequence[Array], repeats: int, frame_s: float = 1 / 30, start_s: float = 0.0
) -> SimulatedCourse:
    """A camera that stands at each of the poses for some frames."""
    checked_frames(len(T_world_camera) * repeats)
    poses = np.repeat(np.asarray(T_world_camera, float).reshape(-1, 4, 4), repeats, axis=0)
    return SimulatedCourse(stamps(len(poses), frame_s, start_s), poses)


def turning(
    table: Turntable, T_world_camera: Array, frame_s: float = 0.5, start_s: float = 0.0, continuous: bool = False
) -> SimulatedCourse:
    """A camera that stands still before a turntable."""
    checked_frames(table.frames)
    poses = np.broadcast_to(T_world_camera, (table.frames, 4, 4))
    return SimulatedCourse(stamps(table.frames, frame_s, start_s), poses, table, continuous)


def stamps(frames: int, frame_s: float, start_s: float = 0.0) -> NDArray[np.float64]:
    """(frames,) time stamps [s], `frame_s` apart."""
    checked_frames(frames)
    if not (np.isfinite([frame_s, start_s]).all() and 1e-6 <= frame_s <= 1e6 and abs(start_s) <= 1e9):
        raise SceneError("the time between frames cannot be used", found=f"{frame_s} s from {start_s} s")
    return start_s + frame_s * np.arange(frames, dtype=np.float64)


def checked_frames(frames: int) -> None:
    """Raises SceneError before memory is asked for."""
    if not 1 <= frames <= MOST_FRAMES:
        raise SceneError("the number of frames cannot be used", found=frames, expected=f"1 to {MOST_FRAMES}")


def looking_at(eye: Array, target: Array, roll: float = 0.0) -> Array:
    """The pose (4, 4) of a camera at `eye` [m] that looks at `target`, upright in a world with z up.

    `roll` [rad] turns it about its axis, its picture clockwise. Looking straight up or down, right is +y.
    """
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    away = float(np.linalg.norm(target - eye))
    if not away > 0:
        raise SceneError("the camera looks at its own place", found=eye.tolist(), expected="another target")
    z = (target - eye) / away
    x = np.cross(z, [0.0, 0.0, 1.0])
    x = x / np.linalg.norm(x) if np.linalg.norm(x) > 1e-9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    return pose(np.column_stack([c * x - s * y, s * x + c * y, z]), eye)


def neighbours(course: SimulatedCourse, index: int) -> tuple[int, int, float] | None:
    """The frames before and after one, and the time between them [s]; None where things stop for each frame."""
    before, after = max(index - 1, 0), min(index + 1, len(course) - 1)
    if not course.continuous or before == after:
        return None
    return before, after, float(course.timestamps[after] - course.timestamps[before])
