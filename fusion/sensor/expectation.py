"""What a sensor model lets one observe of a view, in repeated frames."""

from dataclasses import dataclass

import numpy as np

from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Expectation:
    """What repeated frames of one view show.

    Attributes:
        mean: (h, w) of the depth [m].
        sigma: (h, w) its standard deviation [m].
        dropout: (h, w) missing share [1].
    """

    mean: Image
    sigma: Image
    dropout: Image


def expectation(sensor: Sensor, view: View) -> Expectation:
    """Mean, spread and missing share that a sensor gives of a view (its depth is the truth)."""
    if view.depth is None:
        raise ValueError("the view has no depth")
    depth = np.asarray(view.depth)
    return Expectation(*sensor.repeated(depth, view), sensor.dropout(depth, view))
