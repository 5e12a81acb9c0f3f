"""How large tiles are: as small as the time that many of them take allows."""

from dataclasses import replace

import made_up_walls
import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.naming import name_effects
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe import observations
from fusion.discrepancy.observe.interior import EDGE_PX, interior, reach
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.tiles import SIDE_PX, tiling, usual_side
from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.view import View


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


@pytest.mark.parametrize(
    ("width", "height", "tiles"), [(640, 480, 40 * 30), (112, 80, 7 * 5), (32, 24, 35), (8, 8, 64)]
)
def test_an_image_of_any_size_makes_tiles(width, height, tiles):
    every = np.ones((height, width), bool)
    assert len(tiling(every)) == tiles
    assert usual_side(every.shape) <= SIDE_PX


@pytest.mark.parametrize(("width", "pixels"), [(640, 5.0), (100, 5.0), (32, 1.6), (8, 1.0)])
def test_edges_reach_over_fewer_of_fewer_pixels(width, pixels):
    assert reach(EDGE_PX, width) == pytest.approx(pixels)


@pytest.mark.parametrize(("width", "kept"), [(8, True), (64, False)])
def test_where_every_pixel_sees_several_materials_print_is_no_edge(width, kept):
    camera = Camera(width, width, width, width, width / 2, width / 2)
    checkered = 0.2 + 0.6 * (np.indices((width, width)).sum(axis=0) % 2)
    assert interior(View(camera, reflectance=checkered)).any() == kept


@pytest.mark.parametrize(("hidden", "name"), [(DepthScale(scale=0.01), "depth_scale"), (None, None)])
def test_a_sensor_of_eight_zones_by_eight_tells_what_is_missing(monkeypatch, hidden: Effect | None, name):
    monkeypatch.setattr(made_up_walls, "WIDTH", 8)
    monkeypatch.setattr(made_up_walls, "HEIGHT", 8)
    monkeypatch.setattr(
        made_up_walls, "Camera", lambda w, h, *_, principle: Camera(w, h, 9, 9, 3.5, 3.5, principle=principle)
    )
    blocks = looks_at(sensor_of("itof", *([hidden] if hidden else [])), 3)
    seen = observe(sensor_of("itof"), blocks)
    assert len(seen.residual) > 60 * len(blocks)
    covariance = covariance_of(seen)
    found = name_effects(blocks, seen, covariance, candidates_of(seen, covariance))
    assert [step.effect.name for step in found.steps] == ([name] if name else [])
