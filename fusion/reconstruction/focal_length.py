"""What landmarks say of the focal length: a thing keeps its shape when it is seen from another side.

With a wrong focal length all lengths across the view are wrong and those along it are not, so that views that are
turned to each other disagree: to first order p = (1 + e E) P, E = diag(1, 1, 0), e = f_right / f_stated - 1. Landmarks
A, B of two views are the same points, (1 - e E) A = R (1 - e E) B + t, and what a motion leaves is A - (R B + t) =
e (E A - R E B). The right side takes the best place of each point by both: errors of A and B themselves are in both
sides, and 10 mm of them looked like 1.5 % of the focal length (errors in variables; Fuller 1987, sec. 1.1).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.geometry.robust import DOUBT, SURE
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.results.light import Light
from fusion.tracking.landmarks import PLACED, Landmarks, meet, moved_by

TURNED = np.deg2rad(15), np.deg2rad(60)  # between two views: less shows no shape from elsewhere, more no landmark
PAIRS = 60  # are looked at, in even steps through all that there are
FEWEST = 8  # of them tell how far they disagree (guess)
SYSTEMATIC = 0.005  # of the focal length: what two simulated rooms were off by, whose depth was right
VAGUE = 0.01  # relative standard deviation from which it is not called right (guess)
CALIBRATE = "Calibrate the camera (fusion calibrate intrinsics), and the depth."


@dataclass(frozen=True)
class FocalSeen:
    """What landmarks say of the focal length."""

    relative: float  # f_right / f_stated - 1
    std: float  # as pairs of views disagree, those that share a view together
    pairs: int

    @property
    def spread(self) -> float:
        """Relative standard deviation of what is said."""
        return float(np.hypot(self.std, SYSTEMATIC))

    @property
    def stated_std(self) -> float:
        """What the stated focal length, which is used, may be wrong by: what they ask for, where they are sure."""
        return max(self.spread, abs(self.relative) if abs(self.relative) > DOUBT * self.spread else 0.0)

    def light(self, camera: Camera) -> Light | None:
        """As a sentence; None where they tell too little."""
        spread = float(np.hypot(self.spread, camera.std.get("fx", 0.0) / camera.fx))
        said = f"({100 * self.relative:+.1f} +- {100 * spread:.1f} %)"
        if abs(self.relative) <= DOUBT * spread:
            kept = f"Landmarks keep their shape with the stated focal length {said}."
            return None if spread > VAGUE else Light("ok", "Camera", kept)
        told = f"Landmarks keep their shape only with fx {camera.fx * (1 + self.relative):.1f} instead of "
        told += f"{camera.fx:.1f} px {said}, or with another depth: lengths are wrong by about as much"
        return Light("bad" if abs(self.relative) > SURE * spread else "warning", "Camera", f"{told}.", CALIBRATE)


def focal_of(frames: Sequence[Keyframe], poses: Array) -> FocalSeen | None:
    """The focal length by the key frames of a recording with poses (n, 4, 4); None where they tell nothing."""
    own = poses[np.array([frame.index for frame in frames], int)]
    return focal_seen([frame.landmarks for frame in frames], own, frames[0].surface.camera.fx) if frames else None


def focal_seen(shown: Sequence[Landmarks | None], poses: Array, fx: float) -> FocalSeen | None:
    """The focal length by landmarks of views; None with too few.

    Args:
        poses: (n, 4, 4) about where they are, NaN where unknown.
        fx: focal length [px] of the images that show the landmarks.
    """
    found = [k for k, marks in enumerate(shown) if marks is not None and np.isfinite(poses[k]).all()]
    ways = [(i, j) for n, j in enumerate(found) for i in found[:n] if TURNED[0] < _turn(poses, i, j) < TURNED[1]]
    used, sums = [], []
    for i, j in [ways[int(k)] for k in np.linspace(0, len(ways) - 1, min(PAIRS, len(ways)))]:
        told = _strained(shown[i], shown[j], fx)
        if told is not None:
            used.append((i, j))
            sums.append(told)
    if len(used) < FEWEST:
        return None
    products, squares = np.array(sums).T
    relative = float(products.sum() / squares.sum())
    misses = products - relative * squares
    together = np.zeros(len(poses))  # a view's errors are in all its pairs (Aronow, Samii and Assenova 2015)
    for (i, j), miss in zip(used, misses, strict=True):
        together[[i, j]] += miss
    variance = max(float((together**2).sum() - (misses**2).sum()), float((misses**2).sum()))
    return FocalSeen(relative, float(np.sqrt(variance) / squares.sum()), len(used))


def _turn(poses: Array, i: int, j: int) -> float:
    return angle(inverse(poses[i]) @ poses[j])


def _strained(a: Landmarks | None, b: Landmarks | None, fx: float) -> Array | None:
    """(2,) of one pair: products of what a motion leaves with what a strain would, and squares of that, weighed."""
    met = None if a is None or b is None else meet(a, b)
    if met is None or a is None or b is None:
        return None
    T, R = met.T_a_b, met.T_a_b[:3, :3]
    here, there = a.points[met.left], transform(T, b.points[met.right])
    left = _covariances(a, met.left, fx)
    both = left + R @ _covariances(b, met.right, fx) @ R.T
    off = here - there
    best = here - (left @ np.linalg.solve(both, off[:, :, None]))[:, :, 0]
    across = np.diag([1.0, 1.0, 0.0])
    strain = best @ across - (best - T[:3, 3]) @ R @ across @ R.T
    columns = np.concatenate([np.dstack([off, strain]), moved_by(best - best.mean(axis=0))], axis=2)  # (m, 3, 8)
    white = np.linalg.solve(np.linalg.cholesky(both), columns).reshape(-1, 8)
    free = np.linalg.qr(white[:, 2:])[0]
    asked = white[:, 1] - free @ (free.T @ white[:, 1])
    return np.array([white[:, 0] @ asked, asked @ asked])


def _covariances(marks: Landmarks, some: NDArray[np.int64], fx: float) -> Array:
    """(m, 3, 3) of the places of some landmarks, in their camera's frame: across the ray by the image, along it."""
    points = marks.points[some]
    across = (PLACED * points[:, 2] / fx) ** 2
    along = np.maximum(marks.sigma[some] ** 2 - across, 0.0)
    rays = points / np.linalg.norm(points, axis=1)[:, None]
    turned = rays[:, :, None] * rays[:, None, :]
    return across[:, None, None] * (np.eye(3) - turned) + along[:, None, None] * turned
