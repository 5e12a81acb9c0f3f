"""Table: a recording whose object turns, seen from the object: the axis about which it does."""

from dataclasses import dataclass

import numpy as np

from fusion.geometry.pose import Array, inverse
from fusion.recording.native.scene_file import CourseFields, SceneFields, scene_content, stated_scene
from fusion.recording.recording import Recording
from fusion.sensor.moments import moments_of

LEAST_TURN = np.deg2rad(5.0)


@dataclass(frozen=True)
class LoggedTable:
    """The turntable of a recording, in the frame of its poses, in which the object rests.

    Attributes:
        point, direction: (3,) of the axis [m]; the object turns right-handed about it by the logged angle.
    """

    point: Array
    direction: Array

    def in_camera(self, T_world_camera: Array) -> tuple[Array, Array]:
        """A point of the axis and its direction in the camera frame."""
        T = inverse(T_world_camera)
        return T[:3, :3] @ self.point + T[:3, 3], T[:3, :3] @ self.direction


def table_of(recording: Recording) -> LoggedTable | None:
    """The turntable whose angles were logged; None where there is none, or where the poses do not follow it.

    Raises:
        RecordingError: the axis in `scene.json` is none.
    """
    angle = moments_of(recording).table_angle
    if recording.poses is None or not np.isfinite(angle).all() or np.ptp(angle) < LEAST_TURN:
        return None
    poses = recording.poses.at(recording.timestamps).poses
    known = np.isfinite(poses).all(axis=(1, 2))
    if known.sum() < 2 or not _follow(poses[known], angle[known]):
        return None
    stated = _stated(recording)
    point, direction = stated if stated is not None else _axis(poses[known], angle[known])
    return LoggedTable(point, direction)


def _follow(poses: Array, angle: Array) -> bool:
    """True when poses turn as the log says: the object's frame, and not that of the room."""
    last = int(np.argmax(np.abs(np.sin((angle - angle[0]) / 2))))
    turned = (np.trace((poses[last] @ inverse(poses[0]))[:3, :3]) - 1) / 2
    return bool(abs(np.arccos(np.clip(turned, -1, 1)) - _folded(angle[last] - angle[0])) < LEAST_TURN)


def _folded(angle: float) -> float:
    """The same turn as an angle from 0 to pi."""
    return float(abs((angle + np.pi) % (2 * np.pi) - np.pi))


def _stated(recording: Recording) -> tuple[Array, Array] | None:
    about = stated_scene(recording).trajectory
    table = about.turntable if isinstance(about, CourseFields) else None
    if table is None or table.axis_point is None or table.axis_direction is None:
        return None
    direction = np.array(table.axis_direction)
    if not np.any(direction):
        place, must = ("trajectory", "turntable", "axis_direction"), "a direction: three numbers, not all 0"
        raise scene_content(recording).wrong(SceneFields, *place, expected=must)
    return np.array(table.axis_point), direction / np.linalg.norm(direction)


def _axis(poses: Array, angle: Array) -> tuple[Array, Array]:
    """The axis about which the poses turn: seen from the object, the camera goes round it backwards."""
    rows, ends, turns = [], [], []
    for T, turned in zip(poses[1:], angle[1:] - angle[0], strict=True):
        if _folded(turned) < LEAST_TURN:
            continue
        motion = T @ inverse(poses[0])
        R = motion[:3, :3]
        skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        turns.append(-skew * np.sign(np.sin(turned)))
        rows.append(np.eye(3) - R)
        ends.append(motion[:3, 3])
    direction = np.sum(turns, axis=0)
    direction = direction / np.linalg.norm(direction)
    # the point nearest to the origin that stays where it is
    rows.append(direction[None])
    ends.append(np.zeros(1))
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(ends), rcond=None)[0], direction
