"""Amplitude images tell of the lamp, whatever the targets, the gain and the gloss are."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.light.steps import amplitude_steps, shown_by_light
from fusion.discrepancy.observe.observations import observe
from fusion.geometry.camera import Camera
from fusion.geometry.pose import pose
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.view import incidence_of

SENSOR = sensor_of("itof")
CAMERA = Camera(224, 160, 140.0, 140.0, 111.5, 79.5, principle="itof")
# distance [m], turn about the vertical and the horizontal [deg]
FRONTAL = [(d, 0, 0) for d in (0.7, 0.9, 1.2, 1.6, 2.1, 2.8)]
TILTED = [(1.0, 35, 0), (1.5, -35, 5), (1.3, 5, 30), (2.0, -10, -30)]


def lit_walls(walls, exponent=0.0, print_=lambda place, view, rng: 0.0, seed=0):
    """Walls of one paint whose amplitude images were made with a lamp, and what is on each wall (log amplitude)."""
    rng, sensor, blocks = np.random.default_rng(seed), SENSOR.having(IlluminationVignetting(exponent=exponent)), []
    for place, (distance, turn, nod) in enumerate(walls):
        x, y = np.moveaxis(CAMERA.rays(), -1, 0)
        a, b = np.tan(np.deg2rad((turn, nod)))
        depth = distance / (1.0 - a * x - b * y)
        normal = np.array([a, b, -1.0]) / np.sqrt(a * a + b * b + 1.0)
        normals = np.broadcast_to(normal, (*CAMERA.shape, 3))
        block = looks_at(SENSOR, 1)[0]
        view = replace(block.view, camera=CAMERA, depth=depth, normals=normals, edges=None, ir=None, velocity=None)
        view = replace(view, incidence=incidence_of(normals, CAMERA), reflectance=np.full(CAMERA.shape, 0.6))
        gain = rng.uniform(0.5, 2.0)
        light = gain * sensor.amplitude(view) * np.exp(print_(place, view, rng))
        ir = np.clip(np.rint(light * (1 + 0.03 * rng.standard_normal(CAMERA.shape))), 0, 65535)
        frames = depth + 0.002 * rng.standard_normal((6, *CAMERA.shape))
        stage = type(block.stage)(**{**vars(block.stage), "place": place})
        across = np.cross([0.0, 1.0, 0.0], normal) / np.hypot(normal[0], normal[2])
        axes = np.array([across, np.cross(normal, across), normal])  # of the wall, which all recordings share
        T_world_camera = pose(axes, -axes @ [0.0, 0.0, distance])
        block = replace(block, T_world_camera=T_world_camera, stage=stage, view=replace(view, ir=ir))
        block = replace(block, mean=frames.mean(axis=0), std=frames.std(axis=0), count=np.full(CAMERA.shape, 6))
        blocks.append(block)
    return observe(SENSOR, blocks)


def painted(place, view, rng, rms=0.15):
    """Another smooth pattern on every wall."""
    field = gaussian_filter(rng.standard_normal(CAMERA.shape), 25)
    return rms * field / field.std()


def plain(place, view, rng):
    """As even as painters paint."""
    return painted(place, view, rng, rms=0.01)


def glossy(place, view, rng):
    return np.log1p(0.8 * np.exp(-0.5 * (view.incidence / np.deg2rad(15)) ** 2))


def dark_border(place, view, rng):
    """One wall that is darker away from its middle, seen from all distances."""
    x, y = np.moveaxis(CAMERA.rays(), -1, 0)
    return -0.3 * view.depth**2 * (x**2 + y**2)


def aside(place, view, rng):
    """A lamp that is brightest on one side: no law of the catalogue."""
    return 0.4 * CAMERA.rays()[..., 0]


def test_a_lamp_that_is_brightest_on_its_axis_is_named_beside_gain_and_paint():
    sensor, (step,) = amplitude_steps(lit_walls(FRONTAL + TILTED, exponent=2.0, print_=plain))
    assert step.established and step.channel == "amplitude" and step.alike == ()
    found = sensor.effect("illumination_vignetting")
    # the patterns of ten walls leave a tenth of it open
    assert abs(found.exponent - 2.0) < 3 * step.std["exponent"] < 1.0


@pytest.mark.parametrize("print_", [painted, glossy, dark_border, aside])
@pytest.mark.parametrize("walls", [FRONTAL + TILTED, FRONTAL])
def test_what_targets_or_other_lamps_do_is_not_named(walls, print_):
    for seed in range(3):
        assert amplitude_steps(lit_walls(walls, print_=print_, seed=seed))[1] == ()


def test_frontal_walls_cannot_tell_a_lamp_from_gloss_and_so_it_is_not_shown():
    assert shown_by_light(lit_walls(FRONTAL, exponent=2.0)) == set()
    assert shown_by_light(lit_walls(FRONTAL + TILTED)) == {"illumination_vignetting"}


def test_without_amplitude_images_nothing_is_asked():
    seen = lit_walls(FRONTAL + TILTED, exponent=2.0)
    dark = [replace(p.block, view=replace(p.block.view, ir=None)) for p in seen.patches]
    assert amplitude_steps(observe(SENSOR, dark)) == (SENSOR, ())
