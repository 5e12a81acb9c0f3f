"""Sudden moves that no turn about the axis makes: the object was pushed, or the camera was."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose

Array = NDArray[np.float64]
BESIDE = 4  # frames on either side of a jump that must agree
UNUSUAL = 6.0  # robust spreads of such differences all over the scan
LEAST = 0.0015  # [m] less is in the noise of a depth camera's free tracking (guess)


@dataclass(frozen=True)
class Jump:
    """A sudden move between two frames."""

    frame: int  # the first after it
    distance: float  # by which the object's middle moved against the axis [m]
    who: str  # "object" where the move turns with the table, "camera" where it stands still before the camera


def find_jump(free: Array, by_axis: Array, middle: Array) -> Jump | None:
    """The largest sudden move that freely tracked poses show against those of one axis; None when there is none.

    Errors of depth and drift make the two differ as well, but slowly: a jump is larger than `UNUSUAL` times what
    neighbouring stretches of the same scan usually differ by.

    Args:
        free, by_axis: (n, 4, 4) the camera in the object's frame, NaN where there is none.
        middle: (3,) of the object, in the object's frame [m].
    """
    known = np.flatnonzero(np.isfinite(free).all(axis=(1, 2)) & np.isfinite(by_axis).all(axis=(1, 2)))
    if len(known) < 4 * BESIDE:
        return None
    found = []
    for who in ("object", "camera"):
        moved = np.array([_moved(free[i], by_axis[i], middle, who) for i in known])
        sizes = np.linalg.norm(_differences(moved), axis=1)
        at = int(np.argmax(sizes))
        # the place itself and its neighbours belong to the jump, not to the scan's own wandering
        others = sizes[np.abs(np.arange(len(sizes)) - at) > 2 * BESIDE]
        usual = float(np.median(others)) if len(others) else np.inf
        if sizes[at] > max(LEAST, UNUSUAL * usual):
            jump = Jump(int(known[at + BESIDE]), float(sizes[at]), who)
            found.append((_unrest(moved, at + BESIDE), jump))
    # what a push of the object moved stays with the object, and of the camera with the camera
    return min(found, key=lambda pair: pair[0])[1] if found else None


def _unrest(moved: Array, at: int) -> float:
    """Mean square of what (n, 3) does before and after a place, about the mean of each side [m^2]."""
    return float(np.concatenate([side - side.mean(axis=0) for side in (moved[:at], moved[at:])]).var(axis=0).sum())


def _moved(free: Array, by_axis: Array, middle: Array, who: str) -> Array:
    """(3,) how far the object's middle stands off [m]: in the object's frame, or in the camera's."""
    if who == "object":
        return np.asarray(pose.transform(free @ pose.inverse(by_axis), middle) - middle)
    seen = pose.transform(pose.inverse(by_axis), middle)
    return np.asarray(pose.transform(pose.inverse(free), middle) - seen)


def _differences(moved: Array) -> Array:
    """Medians of the frames after minus those before each place (n - 2 * BESIDE + 1, 3)."""
    windows = np.median(np.lib.stride_tricks.sliding_window_view(moved, BESIDE, axis=0), axis=-1)
    return np.asarray(windows[BESIDE:] - windows[:-BESIDE])
