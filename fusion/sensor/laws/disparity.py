"""Disparity: the native unit of triangulation, in which many laws are constants."""

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image, View


def disparity(depth: Image, view: View) -> Image:
    """d = fx b / z (h, w) [px]."""
    return depth.dtype.type(view.focal_baseline) / depth


def depth_change(depth: Image, shift: float | NDArray[np.floating], view: View) -> Image:
    """Change (h, w) [m] of the depth when its disparity is measured larger by `shift`, a number or (h, w) [px].

    fx b / (d + shift) - z, written without a difference of large numbers.
    """
    relative = depth * (np.asarray(shift, depth.dtype) / depth.dtype.type(view.focal_baseline))
    return -depth * relative / (1 + relative)
