"""How good each pixel of a corrected depth image is: its standard deviation, and its weight."""

from dataclasses import replace

import numpy as np

from fusion.sensor.sensor import SMALLEST_SIGMA, Sensor
from fusion.sensor.view import Image, View


def rated(sensor: Sensor, view: View) -> tuple[Image, Image]:
    """Standard deviation (h, w) [m], NaN where missing, and weight (1 - dropout) / sigma^2 (h, w) [1/m^2], 0 there.

    Args:
        view: with the corrected depth; the incidence, the amplitude and the moment as far as they are known.
    """
    assert view.depth is not None
    depth = np.asarray(view.depth, np.float32)
    principle = view.principle or (sensor.principle if sensor.principle != "unknown" else "")
    view = replace(view, depth=depth, baseline=sensor.baseline, principle=principle)
    with np.errstate(all="ignore"):
        sigma = np.where(np.isfinite(depth), np.float32(0), np.float32(np.nan))
        for effect in sensor.effects:
            sigma = effect.spread(sigma, depth, view)
        sigma = np.broadcast_to(sigma, depth.shape).astype(np.float32)
        weight = (1 - sensor.dropout(depth, view)) / np.maximum(sigma, SMALLEST_SIGMA) ** 2
    return sigma, np.nan_to_num(weight, nan=0.0, posinf=0.0).astype(np.float32)
