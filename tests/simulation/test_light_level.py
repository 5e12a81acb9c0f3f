"""A sensor whose two noise laws imply how much light comes back."""

import numpy as np
import pytest

from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.light_level import BRIGHT, with_light_level


@pytest.mark.parametrize(("shot", "floor"), [(0.003, 0.0), (0.0, 0.003), (0.003, 0.003)])
def test_the_level_is_the_one_at_which_both_laws_agree(shot, floor):
    level, z = 9000.0, np.linspace(0.5, 4, 50)
    q = 1000.0 * z**2 / (level * BRIGHT)
    c2, c1, c0 = np.polyfit(z, np.sqrt(shot**2 * q + floor**2 * q**2), 2)
    noise = AxialNoise(c0=c0, c1=c1, c2=c2, shot=shot, floor=floor, ir_reference=1000.0)
    found = with_light_level(Sensor(principle="itof", effects=(noise, IlluminationVignetting(exponent=2.0))))
    lamp = found.effect("illumination_vignetting")
    assert lamp.exponent == 2.0
    assert lamp.ir_at_1m == pytest.approx(level, rel=0.05)  # a parabola is not quite a root
    assert "light level" in found.warnings[-1]


def test_a_sensor_that_says_it_or_knows_nothing_is_left_as_it_is():
    known = IlluminationVignetting(exponent=1.0, ir_at_1m=500.0)
    noise = AxialNoise(c0=0.001, shot=0.003, floor=0.003, ir_reference=1000.0)
    for sensor in (
        Sensor(),
        preset("kinect-v1"),
        preset("kinect-v2-indoors"),
        Sensor(principle="itof", effects=(noise, known)),
        Sensor(principle="itof", effects=(AxialNoise(c0=0.001),)),
        Sensor(principle="itof", effects=(AxialNoise(shot=0.003, ir_reference=1000.0),)),
    ):
        assert with_light_level(sensor) is sensor
