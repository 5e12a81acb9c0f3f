"""How far a trajectory is from the truth. Code of its own: nothing of the program under test is used."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tools.sets.loop_scenes.place.prints import Array

SAME = 0.002  # [s] two stamps of one frame differ by less


@dataclass(frozen=True)
class Course:
    """Time stamps (n,) [s] and poses (n, 4, 4), camera to world."""

    times: Array
    poses: Array

    @property
    def centres(self) -> Array:
        """(n, 3) [m]."""
        return np.asarray(self.poses[:, :3, 3])

    def at(self, times: Array) -> "Course":
        """Of these frames, those that have a pose."""
        if not len(self.times):
            return self
        nearest = np.abs(self.times[None, :] - times[:, None])
        which = nearest.argmin(axis=1)
        there = nearest[np.arange(len(times)), which] < SAME
        return Course(times[there], self.poses[which[there]])

    def between(self, times: Array) -> "Course":
        """At any times within, turned and shifted evenly from pose to pose."""
        inside = times[(times >= self.times[0]) & (times <= self.times[-1])]
        out = np.tile(np.eye(4), (len(inside), 1, 1))
        out[:, :3, :3] = Slerp(self.times, Rotation.from_matrix(self.poses[:, :3, :3]))(inside).as_matrix()
        out[:, :3, 3] = np.stack([np.interp(inside, self.times, self.centres[:, k]) for k in range(3)], axis=1)
        return Course(inside, out)


def read(file: Path) -> Course:
    """A TUM trajectory; rows that hold NaN are frames without a pose. Empty where there is no file."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    rows = np.array([line.split() for line in lines if line.strip() and line[0] != "#"], float).reshape(-1, 8)
    rows = rows[np.isfinite(rows).all(axis=1)]
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    if len(rows):
        poses[:, :3, :3] = Rotation.from_quat(rows[:, 4:]).as_matrix()
        poses[:, :3, 3] = rows[:, 1:4]
    return Course(rows[:, 0], poses)


@dataclass(frozen=True)
class OffCourse:
    """Attributes:
    ate: [m] rms distance of the camera centres after the best rigid motion, as evo's `evo_ape tum --align`.
    worst: [m] largest of these distances.
    T_truth_found: that motion.
    frames: compared.
    drift: [m], and `drift_deg`: pose of the last frame against the first, beside the true one.
    gap: [m] rms distance by which that moves what the last frame sees: a wall is doubled by so much.
    """

    ate: float
    worst: float
    T_truth_found: Array
    frames: int
    drift: float
    drift_deg: float
    gap: float


def off_course(found: Course, true: Course, points: Array) -> OffCourse:
    """Both over the same frames; `points` (n, 3) [m]: what the last frame sees, in its camera."""
    T = aligned(found.centres, true.centres)
    apart = np.linalg.norm(found.centres @ T[:3, :3].T + T[:3, 3] - true.centres, axis=1)
    E = np.linalg.inv(step(true)) @ step(found)
    moved = np.linalg.norm(points @ E[:3, :3].T + E[:3, 3] - points, axis=1)
    angle = np.rad2deg(Rotation.from_matrix(E[:3, :3]).magnitude())
    rms = float(np.sqrt((apart**2).mean()))
    gap = float(np.sqrt((moved**2).mean()))
    return OffCourse(rms, float(apart.max()), T, len(apart), float(np.linalg.norm(E[:3, 3])), float(angle), gap)


def step(course: Course) -> Array:
    """From the last camera to the first."""
    return np.asarray(np.linalg.inv(course.poses[0]) @ course.poses[-1])


def aligned(points: Array, targets: Array) -> Array:
    """Rigid motion (4, 4) that takes points (n, 3) nearest to targets (n, 3) (Umeyama 1991 without scale)."""
    middle, goal = points.mean(axis=0), targets.mean(axis=0)
    U, _, Vt = np.linalg.svd((targets - goal).T @ (points - middle))
    turn = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = turn, goal - turn @ middle
    return T
