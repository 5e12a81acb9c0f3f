"""Views with holes, of other number types, or that know next to nothing, given to every effect of light and phase."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.effects.light import LIGHT
from fusion.sensor.effects.phase import PHASE
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, Indirect, View

SHAPE = HEIGHT, WIDTH = 24, 32


def seen(principle: str) -> View:
    """A step with everything known."""
    rng = np.random.default_rng(0)
    camera = Camera(WIDTH, HEIGHT, 30.0, 30.0, 16.0, 12.0, principle=principle)
    u = np.arange(WIDTH) * np.ones((HEIGHT, 1))
    depth = np.where(u < 15.6, 1.0, 1.6)
    edges = Edges(np.abs(u - 15.6), np.where(u < 15.6, 0.0, np.pi), np.where(u < 15.6, 0.6, -0.6), np.full(SHAPE, 0.8))
    return View(
        camera,
        depth,
        incidence=np.full(SHAPE, 0.3),
        ir=(1000 / depth**2).astype(np.uint16),
        reflectance=np.full(SHAPE, 0.6),
        edges=edges,
        lit=rng.random(SHAPE),
        indirect=Indirect(np.full(SHAPE, 0.1), np.full(SHAPE, 0.2)),
        velocity=rng.normal(0, 0.5, (*SHAPE, 3)),
        moment=Moment(time=1.234, ambient=300.0),
    )


def torn(thing):
    """The same with NaN in a tenth of every array of numbers with a fraction, at other places in each."""
    rng = np.random.default_rng(1)
    changed = {}
    for entry in fields(thing):
        value = getattr(thing, entry.name)
        if entry.name != "depth" and isinstance(value, np.ndarray) and np.issubdtype(value.dtype, np.floating):
            changed[entry.name] = np.where(rng.random(value.shape) < 0.1, np.nan, value)
        elif isinstance(value, Edges | Indirect) and is_dataclass(value):
            changed[entry.name] = torn(value)
    return replace(thing, **changed)


@pytest.fixture(params=(*LIGHT, *PHASE), ids=lambda kind: kind.name)
def effect(request):
    return request.param(**{p.name: p.typical for p in parameters(request.param).values()})


@pytest.fixture(params=("itof", "structured_light"))
def view(request) -> View:
    return seen(request.param)


def all_of(effect, depth: np.ndarray, view: View) -> list[np.ndarray]:
    with np.errstate(all="ignore"):  # as the sensor does
        return [
            np.broadcast_to(part, SHAPE)
            for part in (effect.bias(depth, view), effect.noise(depth, view), effect.dropout(depth, view))
        ]


def test_holes_in_the_view_make_none_in_the_depth(effect, view):
    bias, noise, dropout = all_of(effect, view.depth, torn(view))
    assert np.isfinite(bias).all() and np.isfinite(noise).all()
    assert (noise >= 0).all() and (dropout >= 0).all() and (dropout <= 1).all()


def test_a_depth_and_a_camera_are_enough(effect, view):
    for part in all_of(effect, view.depth, View(view.camera)):
        assert np.isfinite(part).all()


def test_holes_in_the_depth_stay_where_they_are(effect, view):
    depth = np.where(np.arange(WIDTH) % 7 == 3, np.nan, view.depth).astype(np.float32)
    for part in all_of(effect, depth, replace(view, depth=depth)):
        assert np.isfinite(part[np.isfinite(depth)]).all()
        assert part.dtype == np.float32  # twice the width costs twice the time


def test_nothing_but_holes(effect, view):
    depth = np.full(SHAPE, np.nan)
    sensor = Sensor(effects=(effect,))
    assert np.isnan(sensor.sample(depth, replace(view, depth=depth), None, np.random.default_rng(0))).all()


def test_a_map_of_a_parameter_is_as_good_as_a_number(effect, view):
    about = [p for p in parameters(effect).values() if p.kind == "number"]
    if not about:
        return
    maps = replace(effect, **{p.name: np.full(SHAPE, p.typical) for p in about})
    for part, expected in zip(all_of(maps, view.depth, view), all_of(effect, view.depth, view), strict=True):
        assert part == pytest.approx(expected, rel=1e-5, abs=1e-9)  # exponents are single precision in one of them
    light = np.full(SHAPE, 500.0)
    assert maps.light(light, view.depth, view) == pytest.approx(effect.light(light, view.depth, view), rel=1e-5)
