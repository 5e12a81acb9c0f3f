"""Beside depth edges values are missing where a projector does not reach; tiles end before them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import FRAMES, sensor_of, view_of

from fusion.discrepancy.channels.dropout import dropout_steps
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow, shadowed
from fusion.sensor.view import Edges


def before_a_wall(place, lost_of, near=None):
    """A plate on the left of the image, before a wall; `lost_of` says of the depth and the view what is missing."""
    near = 0.8 + 0.15 * place if near is None else near
    view = view_of("structured_light", (near + 0.5, 0, 0), place)
    u = np.broadcast_to(np.arange(view.camera.width, dtype=float), view.camera.shape)
    edge = 40.0 + 6 * place
    depth = np.where(u < edge, near, view.depth)
    nowhere = np.zeros(view.camera.shape)
    view = replace(view, depth=depth, edges=Edges(np.abs(u + 0.5 - edge), nowhere, nowhere, nowhere + 1))
    rng = np.random.default_rng(place)
    std = 0.03 * depth**2 / view.focal_baseline
    lost = np.broadcast_to(lost_of(depth, view), depth.shape)
    mean = np.where(lost, np.nan, depth + std * rng.standard_normal(depth.shape) / np.sqrt(FRAMES))
    stage = SimpleNamespace(place=place, sigma_m=0.001, sigma_rad=0.001, mesh_sigma_m=0.0, caster=None)
    count = np.where(lost, 0, FRAMES).astype(np.int32)
    return FrameBlock(stage, tuple(range(FRAMES)), view, mean, np.where(lost, np.nan, std), count)


def found(lost_of, sensor=None):
    sensor = sensor or sensor_of("structured_light")
    return dropout_steps(observe(sensor, [before_a_wall(place, lost_of) for place in range(5)]))[1]


def test_the_shadow_of_a_projector_is_named_and_its_place_is_found():
    (step,) = found(lambda depth, view: shadowed(depth, -0.075, view))
    assert step.effect.name == "projector_shadow"
    # a pixel of the shadow's width, which is 6 to 12 px
    assert step.effect.baseline == pytest.approx(-0.075, abs=0.008)


def test_no_values_are_missing_and_none_is_told():
    assert not found(lambda depth, view: False)


def test_values_that_are_missing_on_both_sides_are_no_shadow():
    assert not found(lambda depth, view: view.edges.distance < 3)


def test_a_shadow_that_the_model_holds_is_not_missing():
    held = sensor_of("structured_light", ProjectorShadow(baseline=-0.075))
    assert not found(lambda depth, view: shadowed(depth, -0.075, view), held)
