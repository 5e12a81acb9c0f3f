"""An effect that is not in the catalogue acts in a sensor like the others, between measuring and readout."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import fusion
from fusion.sensor.effects import EFFECTS, place_of
from fusion.sensor.effects.readout import READOUT
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.depth_scale import DepthScale

CAMERA = fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5)


@dataclass(frozen=True)
class Stepped(fusion.Effect):
    """Another offset left of the middle than right of it."""

    name: ClassVar[str] = "stepped"
    height: float = fusion.parameter("m", (-0.1, 0.1), "offset on the right", "this test")

    def bias(self, depth: np.ndarray, view: fusion.View) -> np.ndarray:
        return np.where(view.u > view.camera.cx, self.height, 0).astype(depth.dtype)


def test_it_acts_before_the_readout_and_behind_all_else():
    place = place_of(Stepped())
    for kind in EFFECTS:
        assert (place_of(kind()) > place) == (kind in READOUT)


def test_order_does_not_depend_on_how_it_was_given():
    given = (DepthScale(scale=0.1), Stepped(height=0.01))
    sensors = [fusion.Sensor(effects=effects) for effects in (given, given[::-1])]
    assert [effect.name for effect in sensors[0].effects] == ["stepped", "depth_scale"]
    assert sensors[0] == sensors[1]
    measured = sensors[0].predict(np.full(CAMERA.shape, 1.0, np.float32), CAMERA)
    assert measured[0, -1] == pytest.approx(1.1 * 1.01, abs=1e-6)  # the scale acts on the step too


def test_it_is_simulated_and_undone():
    sensor = fusion.Sensor(effects=(Stepped(height=0.01),))
    wall = np.full(CAMERA.shape, 1.0, np.float32)
    frame = fusion.sense(wall, CAMERA, sensor, seed=1)
    assert np.ptp(frame.depth) == pytest.approx(0.01, abs=1e-6)
    assert np.abs(sensor.correct(frame.depth, CAMERA) - wall).max() < 1e-5  # what `correct` promises


def test_rounding_comes_last():
    rounded = DepthQuantization(step=0.02)
    sensor = fusion.Sensor(effects=(rounded, Stepped(height=0.013)))
    depth = fusion.sense(np.full(CAMERA.shape, 1.0, np.float32), CAMERA, sensor, seed=1).depth
    assert np.abs(depth / 0.02 - np.round(depth / 0.02)).max() < 1e-4
