"""Views: poses from which one recording alone saw its scene, far enough apart to stand for recordings."""

from collections.abc import Sequence

import numpy as np

from fusion.geometry.pose import Array

TURNED, MOVED = 0.1, 0.1  # [rad], [m] guess: another side of a thing, beyond what a pose is off


def views_of(poses: Sequence[Array]) -> list[int]:
    """Number of the view of each pose T_world_camera (4, 4); near ones share the number of the first."""
    firsts: list[Array] = []
    numbers = []
    for pose in poses:
        number = next((k for k, first in enumerate(firsts) if _near(first, pose)), len(firsts))
        if number == len(firsts):
            firsts.append(pose)
        numbers.append(number)
    return numbers


def _near(one: Array, other: Array) -> bool:
    between = np.linalg.solve(one, other)
    turned = np.arccos(np.clip((np.trace(between[:3, :3]) - 1) / 2, -1, 1))
    return bool(turned < TURNED and np.linalg.norm(between[:3, 3]) < MOVED)
