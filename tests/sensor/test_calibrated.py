"""How well a calibrated depth is known."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.correction.unit import LEAST, MOST, depth_std, tilt_std
from fusion.sensor.effects.phase.column_delay import ColumnDelay
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.sensor import Sensor

CAMERA = Camera(320, 240, 290.0, 290.0, 160.0, 120.0)


def sensor(effect, parameter, std):
    return replace(Sensor(effects=(effect,), std={(effect.name, parameter): std}), fitted=frozenset({effect.name}))


def test_a_depth_that_nobody_calibrated_has_none():
    assert depth_std(Sensor(effects=(DepthOffset(0.01),)), CAMERA, 1.0) is None


def test_metres_and_pixels():
    assert depth_std(sensor(DepthOffset(0.01), "offset", 1e-3), CAMERA, 1.0) == pytest.approx(1e-3)
    model = sensor(DisparityOffset(0.1), "offset", 0.02)
    expected = 0.02 * 0.8**2 / (290.0 * abs(model.baseline))
    assert depth_std(model, CAMERA, 0.8) == pytest.approx(np.clip(expected, LEAST, MOST))


def test_no_calibration_is_perfect_nor_without_worth():
    assert depth_std(sensor(DepthOffset(0.01), "offset", 0.0), CAMERA, 1.0) == LEAST
    assert depth_std(sensor(DepthOffset(0.5), "offset", 0.1), CAMERA, 1.0) == MOST


def test_tilts_are_known_as_far_as_boards_showed_them():
    assert tilt_std(sensor(DepthOffset(0.01), "offset", 1e-3), CAMERA) == (np.inf, np.inf)
    known = sensor(ColumnDelay(1e-4), "slope", 2e-6)
    assert tilt_std(known, CAMERA) == (pytest.approx(580e-6), np.inf)  # 2e-6 m a pixel, 290 pixels per unit of ray
    assert tilt_std(replace(known, fitted=frozenset()), CAMERA) == (np.inf, np.inf)  # stated, by nobody's board
