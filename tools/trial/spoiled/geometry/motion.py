"""Small rigid motions of a camera."""

import cv2
import numpy as np

from tools.trial.spoiled.folder import Array


def nudged(T: Array, motion: Array) -> Array:
    """T (4, 4) moved by `motion` (6,): rotation vector [rad] and translation [m] in the camera's own axes."""
    step = np.eye(4)
    step[:3, :3] = cv2.Rodrigues(np.asarray(motion[:3], float))[0]
    step[:3, 3] = motion[3:]
    return np.asarray(T @ step)
