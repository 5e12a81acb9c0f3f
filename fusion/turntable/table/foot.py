"""The upright of what the object stands on, and about where an axis along it passes through the object."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]
FLAT = 0.04  # of half the object's largest extent, off a plane (guess)
TRIES = 300
SOME = 4000  # points that are looked at
EACH = 1000  # of each view
STAYS = 0.9  # share of the views that show a plate
LEAST = 0.03  # share of the background that makes a foot (guess)
UNDER = 0.5  # of the object's size: so far below the lowest that is seen a foot may lie, as below a ball (guess)
ABOVE = 0.97  # share of the object above the foot (guess)
UPWARDS = 0.15  # least cosine between the image's up and the foot's: no camera is held on its side (guess)


def plate_among(views: Sequence[ObjectView]) -> tuple[Array, Array] | None:
    """A point (3,) and the upward unit normal (3,) of a plate that counts as what turns; None where it does not.

    So it is where the object swings far about the axis. All of the object stands on it, and it stays where it is: a
    face of a box has other places in other views.
    """
    each = [v.points[:: max(1, len(v.points) // EACH)].astype(float) for v in views if len(v.points)]
    if not each:
        return None
    points = np.concatenate(each)
    found, flat = foot_of(points, points), _flat(points)
    if found is None:
        return None
    a, normal = found
    if normal @ a >= 0:  # what is seen from below, with all of the object beyond it, is the object's own front
        return None
    shares = np.array([np.mean(np.abs((seen - a) @ normal) < flat) for seen in each])
    return found if np.mean(shares > LEAST) >= STAYS else None


def foot_normal(behind: Array, points: Array) -> Array | None:
    """Unit normal (3,) of the level surface under the object, upwards; None when there is none.

    Args:
        behind: (m, 3) what was seen behind the object, camera frame [m].
        points: (n, 3) of the object in all views.
    """
    found = foot_of(behind, points)
    return None if found is None else found[1]


def foot_of(behind: Array, points: Array) -> tuple[Array, Array] | None:
    """A point (3,) and the upward unit normal (3,) of the level surface under the object, see `foot_normal`."""
    (low, high), flat = np.percentile(points, [1, 99], axis=0), _flat(points)
    size = high - low
    near = ((behind > low - size) & (behind < high + size)).all(axis=1)
    under = UNDER * float(size.max())
    behind, some = behind[near], points[:: max(1, len(points) // SOME)]
    if len(behind) < 100:
        return None
    random = np.random.default_rng(0)  # a fixed seed: the same scan gives the same result
    behind = behind[random.permutation(len(behind))[:SOME]]
    best, most = None, LEAST * len(behind)
    for _ in range(TRIES):
        a, b, c = behind[random.integers(len(behind), size=3)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-5 or abs(normal[1]) < UPWARDS * length:
            continue
        normal *= -np.sign(normal[1]) / length
        count = int(np.sum(np.abs((behind - a) @ normal) < flat))
        if count > most and _stands_on((some - a) @ normal, under, flat):
            best, most = (a, normal), count
    if best is None:
        return None
    a, normal = best
    for _ in range(3):
        inside = behind[np.abs((behind - a) @ normal) < flat]
        a = inside.mean(axis=0)
        normal = np.linalg.svd(inside - a, full_matrices=False)[2][2]
    normal = np.asarray(normal * -np.sign(normal[1]))
    # a leaning plane may pass close under what the level one lies far below
    return (a, normal) if _stands_on((some - a) @ normal, under, flat) else None


def _flat(points: Array) -> float:
    """How far off a plane is still on it [m], for points (n, 3) of the object."""
    return FLAT / 2 * float(np.ptp(np.percentile(points, [1, 99], axis=0), axis=0).max())


def _stands_on(height: Array, under: float, flat: float) -> bool:
    lowest = float(np.percentile(height, 2))
    return bool(np.mean(height > -flat) > ABOVE and lowest < under)
