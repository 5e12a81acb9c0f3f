"""The noise of repeated frames: an effect that adds to it is named, and none where it is as the model says."""

import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.channels.spread import spread_step
from fusion.discrepancy.observations import observe
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.phase.sensor_interference import SensorInterference


@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_noise_as_the_model_says_is_nothing(principle):
    for seed in range(3):
        assert spread_step(observe(sensor_of(principle), looks_at(sensor_of(principle), seed))) is None


def test_more_light_is_named_by_its_noise():
    hidden = AmbientLight(ambient=4000.0)
    looks = looks_at(sensor_of("itof", hidden), 1)
    found = spread_step(observe(sensor_of("itof"), looks))
    assert found is not None and "ambient_light" in (found.effect.name, *found.alike)
    # sizes are tried in steps of 1.8
    assert found.effect.ambient == pytest.approx(4000.0, rel=0.9)


def test_another_sensor_is_not_taken_for_light():
    # interference brings noise that grows as the light fades
    looks = looks_at(sensor_of("itof", SensorInterference(fraction=0.3)), 2)
    found = spread_step(observe(sensor_of("itof"), looks))
    assert found is not None and "sensor_interference" in (found.effect.name, *found.alike)
