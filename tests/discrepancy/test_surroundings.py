"""A mean over what surrounds a pixel is no effect: its area, a filter, at creases and at the border."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import HEIGHT, WALLS, WIDTH, view_of
from scipy.ndimage import gaussian_filter, median_filter

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.surroundings import surroundings_columns
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.frames import FrameSeries
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.light.stray_light import StrayLight
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import incidence_of

FRAMES, NOISE_M, FINE_NOISE_M = 8, 0.002, 0.0004
FINE = (np.arange(5) + 0.5) / 5 - 0.5  # px: places in a pixel
# distance of the crease [m], turn about the vertical [deg], height of the camera's tilt [deg]
CORNERS = [(1.0, 0, 0), (1.2, 12, 5), (1.4, -15, -8), (1.7, 5, 10), (2.0, -8, -5), (1.1, 18, -12), (1.5, -20, 6)]


def planes(corner):
    """Normals (2, 3) and distances (2,) of two walls that meet at a right angle before the camera."""
    distance, turn, tilt = corner
    a, b = np.deg2rad(turn), np.deg2rad(tilt)
    turned = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    tilted = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    normals = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0]]) / np.sqrt(2) @ turned.T @ tilted.T
    return normals, -normals @ [0.0, 0.0, distance]


def depth_of(corner, u, v, camera):
    """Depth [m] and number of the wall that is seen at places (h, w) in the image."""
    normals, offsets = planes(corner)
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)], -1)
    both = -offsets / (rays @ normals.T)
    both = np.where(both > 0, both, np.inf)
    return both.min(axis=-1), both.argmin(axis=-1)


def corner_look(place, corner, filtered, seed, hidden=None, noise=NOISE_M):
    """A block at a corner: pixels see their area, each frame is filtered by itself; poses are off as stated."""
    rng = np.random.default_rng([seed, place])
    view = view_of("itof", WALLS[0], place)
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    depth, wall = depth_of(corner, u, v, view.camera)
    normals = planes(corner)[0][wall]
    rays = np.dstack([view.camera.rays(), np.ones(depth.shape)])
    incidence = incidence_of(normals, view.camera)
    ir = 3000.0 * np.cos(incidence) / (depth**2 * (rays**2).sum(axis=-1))
    flat = np.full(depth.shape, 0.5)
    view = replace(view, depth=depth, normals=normals, incidence=incidence, ir=ir, reflectance=flat)
    true = tuple(np.add(corner, rng.normal(0, [0.001, 0.06, 0.06])))
    area = np.mean([depth_of(true, u + a, v + b, view.camera)[0] for a in FINE for b in FINE], axis=0)
    mean = area if hidden is None else area + hidden.bias(depth, view)
    series = FrameSeries(view.camera.shape)
    for _ in range(FRAMES):
        series.add(filtered(mean + rng.normal(0, noise, mean.shape) / view.stretch))
    stage = SimpleNamespace(place=place, sigma_m=0.001, sigma_rad=0.001, mesh_sigma_m=0.0, caster=None)
    pixels = series.pixels
    return FrameBlock(stage, tuple(range(FRAMES)), view, pixels.mean, pixels.std, pixels.count, alike=series.alike)


def none(frame):
    return frame


def smooth(frame):
    return gaussian_filter(frame, 0.8)


def box(frame):
    return median_filter(frame, 3)


def corners(filtered, seed, hidden=None, noise=NOISE_M):
    return [corner_look(place, corner, filtered, seed, hidden, noise) for place, corner in enumerate(CORNERS)]


def found_in(blocks, noise=NOISE_M):
    found = explained_looks(blocks, Sensor("made up", "itof", (AxialNoise(c0=noise),)))
    assert not found.unknown
    return [step.effect for step in found.named.steps]


@pytest.mark.parametrize("filtered", [smooth, box])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_filter_is_no_effect_at_a_crease_and_at_the_border(filtered, seed):
    assert found_in(corners(filtered, seed)) == []


@pytest.mark.parametrize("seed", [1, 2])
def test_the_area_of_a_pixel_is_no_effect_at_a_crease(seed):
    assert found_in(corners(none, seed, noise=FINE_NOISE_M), FINE_NOISE_M) == []


@pytest.mark.parametrize("filtered", [none, smooth, box])
def test_an_offset_keeps_its_name_at_a_crease(filtered):
    (effect,) = found_in(corners(filtered, 1, DepthOffset(offset=0.008)))
    assert effect.name == "depth_offset" and effect.offset == pytest.approx(0.008, abs=0.0005)


def test_light_of_neighbours_keeps_its_name_beside_a_filter():
    (effect,) = found_in(corners(smooth, 1, StrayLight(fraction=0.2, width=8.0)))
    assert effect.name == "stray_light" and effect.width == pytest.approx(8.0, rel=0.3)


@pytest.mark.parametrize(("shared", "some"), [(0.03, False), (0.3, True)])
def test_neighbours_that_are_alike_by_chance_are_no_filter(shared, some):
    """A few per cent, as few frames of few pixels have them, would be a window narrower than the pixel itself."""
    block = corner_look(0, CORNERS[0], lambda image: image, 1)
    alike = np.zeros_like(block.alike)
    alike[:, 0], alike[:, 1] = 1.0, shared
    seen = observe(Sensor("plain", "itof", (AxialNoise(c0=NOISE_M),)), [replace(block, alike=alike)])
    assert bool(np.any(surroundings_columns(seen)[:, 1])) == some
