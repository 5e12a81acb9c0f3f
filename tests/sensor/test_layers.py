"""A stack of images says what the general table says, and is as fast as a curve."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.effects.readout import tabulated
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.laws.layers import Layers
from fusion.sensor.laws.table import interpolated
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

GRID = (tuple(np.linspace(5, 115, 12)), tuple(np.linspace(4, 150, 16)), (0.5, 0.9, 1.0, 2.2))


def test_layers_are_the_table():
    rng = np.random.default_rng(1)
    table = rng.normal(0, 0.01, (12, 16, 4))
    depth = rng.uniform(0.3, 2.6, (120, 160))  # beyond both ends, where the table is held
    depth[3, 7] = np.nan
    v, u = np.arange(120.0)[:, None], np.arange(160.0)[None, :]
    expected = interpolated(table, GRID, [v, u, depth])
    found = Layers(table, GRID, depth.shape).at(depth)
    # float32 places among four layers: 1e-7 of 0.03 m
    assert np.allclose(found, expected, atol=1e-8, equal_nan=True)
    effect = Tabulated(("v", "u", "depth"), GRID, table)
    bias = effect.bias(depth, View(Camera(160, 120, 150, 150, 79.5, 59.5), depth))
    assert np.allclose(bias, np.nan_to_num(expected), atol=1e-8)


def test_a_table_of_single_numbers_gives_a_single_number():
    """Time and temperature are one number each for a whole image."""
    table = np.array([[0.0, 1.0], [2.0, 3.0]])
    assert interpolated(table, ((0.0, 10.0), (20.0, 30.0)), [5.0, 30.0]) == pytest.approx(2.0)
    assert np.isnan(interpolated(table, ((0.0, 10.0), (20.0, 30.0)), [np.nan, 30.0]))


def test_one_layer_is_a_map():
    table = np.arange(12.0).reshape(3, 4, 1)
    found = Layers(table, ((0, 1, 2), (0, 1, 2, 3), (1.0,)), (3, 4)).at(np.full((3, 4), 7.0))
    assert np.allclose(found, table[..., 0])


def test_a_stack_needs_no_general_table(monkeypatch):
    """Which takes four times as long."""
    camera = Camera(640, 480, 585, 585, 319.5, 239.5)
    depth = np.random.default_rng(2).uniform(0.5, 2.0, camera.shape).astype(np.float32)
    asked = []
    monkeypatch.setattr(tabulated, "interpolated", lambda *given: asked.append(given) or depth)
    for variables, grid, table in (
        (("v", "u", "depth"), GRID, np.full((12, 16, 4), 0.01)),
        (("u",), GRID[1:2], np.ones(16)),
    ):
        Tabulated(variables, grid, table).bias(depth, View(camera, depth))
        assert bool(asked) == (variables == ("u",))


@pytest.mark.parametrize("unit", ["values", "values_px"])
@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_a_stack_is_undone_in_one_step(unit: str, principle: str):
    camera = Camera(160, 120, 150, 150, 79.5, 59.5, principle=principle)
    rng = np.random.default_rng(3)
    table = rng.normal(0, {"values": 0.008, "values_px": 0.15}[unit], (12, 16, 4))
    sensor = Sensor(principle=principle, effects=(Tabulated(("v", "u", "depth"), GRID, **{unit: table}),))
    depth = rng.uniform(0.3, 2.6, camera.shape)
    depth[3, 7] = np.nan
    assert sensor.effects[0].corrected(depth, View(camera, depth)) is not None
    # float32 holds 0.3 px to 3e-8, which is as much in m at 3 m, and 2.6 m to 2e-7 in each of some steps
    for dtype, exact in ((np.float64, 1e-7), (np.float32, 3e-6)):
        measured = sensor.predict(depth.astype(dtype), View(camera, depth.astype(dtype)))
        back = sensor.correct(measured, View(camera, measured))
        assert np.allclose(back, depth, rtol=0, atol=exact, equal_nan=True)
