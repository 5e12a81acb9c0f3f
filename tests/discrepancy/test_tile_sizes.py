"""How large tiles are: as small as the time that many of them take allows."""

from dataclasses import replace

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.observe import observations
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.tiles import SIDE_PX


def test_with_too_many_tiles_they_are_no_larger_than_they_must_be(monkeypatch):
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 0)
    usual = observe(sensor, blocks)
    count = len(usual.residual)
    assert {patch.tiles.side for patch in usual.patches} == {SIDE_PX}
    for share in (0.9, 0.4):
        monkeypatch.setattr(observations, "MOST_TILES", share * count)
        fewer = observe(sensor, blocks)
        side = fewer.patches[0].tiles.side
        # the image is some ten tiles wide: those at its border come and go by a tenth, in both directions
        assert 0.7 * share * count < len(fewer.residual) <= share * count
        assert side <= np.ceil(1.1 * SIDE_PX / np.sqrt(share)) + 1


def test_the_model_that_predicted_predicts_no_second_time():
    seen = observe(sensor_of("itof"), looks_at(sensor_of("itof"), 1)[:2])
    assert seen.under(seen.sensor) is seen
    assert seen.under(sensor_of("itof")) is not seen


def test_tiles_of_a_long_series_are_as_small_as_any_where_they_are_few():
    sensor = sensor_of("itof")
    walls = [(1.0 + 0.01 * k, 0.0, 0.0) for k in range(7)]
    series = [replace(block, stage=looks_at(sensor, 2, walls[:1])[0].stage) for block in looks_at(sensor, 2, walls)]
    count = sum(len(patch.tiles) for patch in observe(sensor, series).patches)
    for most, side in ((4 * count, SIDE_PX), (3 * count, 2 * SIDE_PX)):
        assert {patch.tiles.side for patch in observe(sensor, series, most).patches} == {side}
