"""Given: what another simulator predicts of a block, in place of scene and sensor model."""

from dataclasses import dataclass

from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image


@dataclass(frozen=True)
class GivenImages:
    """The images of a simulation for the frames of one block.

    The sensor model that goes with it counts as in the images: what is added to the model later changes them.
    """

    model: Sensor  # that sensor model
    offset: Image  # (h, w) [m] what the simulation predicts beyond the model's mean for the simulated depth
    doubt: Image  # (h, w) [m] standard deviation of the simulated mean: its own noise, averaged over its frames
    lost: Image  # (h, w) share of its frames without a value
    # (h, w) [m] standard deviation of a frame where the model has no noise; None where it has
    spread: Image | None = None
