"""Moment: when and under which conditions a frame was taken."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Moment:
    """The conditions of one frame, as far as sensor effects ask for them.

    Attributes:
        time: since the sensor was switched on [s].
        temperature: of the sensor [degC]; NaN when not known.
        ambient: light that is not the sensor's own, at the surface [lux].
        table_angle: how far the turntable has turned [rad].
        axis_point, axis_direction: (3,) the turntable's axis in the camera frame [m], out of the plate; None when
            there is no table.
        previous: (h, w) the depth that the sensor gave for the frame before [m]; None at the first frame.
        unit: seed of what is frozen into this very sensor (its pixels, its pattern); None: not known.
        placement: seed of what is frozen while the scene stands still (speckle); None: not known.
    """

    time: float = 0.0
    temperature: float = float("nan")
    ambient: float = 0.0
    table_angle: float = 0.0
    axis_point: NDArray[np.float64] | None = None
    axis_direction: NDArray[np.float64] | None = None
    previous: NDArray[np.floating] | None = None
    unit: int | None = None
    placement: int | None = None
