"""Moment: when and under which conditions a frame was taken."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Moment:
    """The conditions of one frame, as far as sensor effects ask for them."""

    time: float = 0.0  # since the sensor was switched on [s]
    temperature: float = float("nan")  # of the sensor [degC]; NaN when not known
    ambient: float = 0.0  # light that is not the sensor's own, at the surface [lux]
    table_angle: float = 0.0  # how far the turntable has turned [rad]
    # axis_point, axis_direction: (3,) the turntable's axis in the camera frame [m], out of the plate; None when there
    # is no table
    axis_point: NDArray[np.float64] | None = None
    axis_direction: NDArray[np.float64] | None = None
    # (h, w) the depth that the sensor gave for the frame before [m]; None at the first frame
    previous: NDArray[np.floating] | None = None
    unit: int | None = None  # seed of what is frozen into this very sensor (its pixels, its pattern); None: not known
    placement: int | None = None  # seed of what is frozen while the scene stands still (speckle); None: not known
