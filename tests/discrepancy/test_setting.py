"""Poses and targets that are worse than stated: their sizes are found, and nothing of it is taken for a law."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import WALLS, looks_at, loose_in, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.competing import _beside_parts, _with_only
from fusion.discrepancy.decisions import CONFIDENCE
from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.camera_file import file_error
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.shapes import bent_m, mesh_off, room_columns, shape_columns
from fusion.discrepancy.inference.sizes import sizes_of
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.setting import posterior, with_laws, without_laws
from fusion.discrepancy.verdict.verdict import nuisances_of
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.laws.surface import moved_rigidly, seen_along

WORSE = 8.0
BOW_M = 0.0012


def worse_posed(sensor, seed):
    """Blocks whose poses are off by `WORSE` times what is stated of them."""
    blocks = looks_at(sensor, seed, off=WORSE)
    return [
        replace(k, stage=SimpleNamespace(**{**vars(k.stage), "sigma_m": 0.001, "sigma_rad": 0.001})) for k in blocks
    ]


def moving(sensor, seed):
    """Blocks of two recordings of a camera that moves, whose every pose is off as far as is stated."""
    walls = [(1.0 + 0.1 * k, 5.0 * (k % 5) - 10.0, 4.0 * (k % 3) - 4.0) for k in range(16)]
    out = []
    for k, block in enumerate(looks_at(sensor, seed, walls)):
        T = np.eye(4)
        T[0, 3] = 0.05 * k
        out.append(replace(block, T_world_camera=T, stage=SimpleNamespace(**{**vars(block.stage), "place": k // 8})))
    return out


def bowed(seed, said=None):
    """Blocks at walls that are each bowed in its own way, of which nothing is said."""
    rng, out = np.random.default_rng([seed, 5]), []
    for k, block in enumerate(looks_at(sensor_of("itof"), seed)):
        field = gaussian_filter(rng.standard_normal(block.mean.shape), 30.0, mode="nearest")
        stage = SimpleNamespace(**{**vars(block.stage), "mesh_sigma_m": said, "shape": f"wall {k}"})
        out.append(replace(block, mean=block.mean + BOW_M * field / field.std(), stage=stage))
    return out


def test_each_view_of_a_moving_camera_has_an_error_of_its_own():
    assert 0.7 < loose_in(moving(sensor_of("itof"), 1)).frames < 1.4
    still = [replace(block, T_world_camera=np.eye(4)) for block in moving(sensor_of("itof"), 1)]
    assert loose_in(still).frames == 0.0


@pytest.mark.parametrize(("hidden", "name"), [((), None), ((DepthOffset(offset=0.004),), "depth_offset")])
def test_what_a_moving_camera_lacks_is_told_beside_the_errors_of_its_views(hidden, name):
    found = explained_looks(moving(sensor_of("itof", *hidden), 2), sensor_of("itof"))
    assert [step.effect.name for step in found.named.steps] == ([name] if name else [])
    assert not found.unknown


def test_the_factor_on_stated_poses_is_found():
    # eight walls tell three directions of each pose: 24 numbers, less what laws reach
    assert WORSE / 2 < loose_in(worse_posed(sensor_of("itof"), 1)).pose < 2 * WORSE
    assert loose_in(looks_at(sensor_of("itof"), 1)).pose == 1.0
    assert loose_in(looks_at(sensor_of("itof", DepthScale(scale=0.01)), 1)).pose == 1.0


def test_a_part_of_the_laws_is_the_better_model_without_the_others():
    given = sensor_of("itof", DepthScale(scale=0.01))
    better = given.having(DepthScale(scale=0.02)).having(DepthOffset(offset=0.003)).having(CyclicError(amplitude=0.002))
    found = {"depth_scale", "depth_offset", "cyclic_error"}
    one = _with_only(better, {"depth_offset"}, found, given)
    assert one.effect("depth_scale") == DepthScale(scale=0.01)
    assert one.effect("depth_offset") == DepthOffset(offset=0.003) and one.effect("cyclic_error") is None
    assert {e.name for e in _with_only(better, found, found, given).effects} == {e.name for e in better.effects}
    assert {e.name for e in _with_only(better, set(), found, given).effects} == {e.name for e in given.effects}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_poses_worse_than_stated_are_no_law(seed):
    found = explained_looks(worse_posed(sensor_of("itof"), seed), sensor_of("itof"))
    assert not found.named.steps and not found.unknown
    assert found.before.loose.pose > WORSE / 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_bows_of_which_nothing_is_said_are_no_law(seed):
    found = explained_looks(bowed(seed), sensor_of("itof"))
    assert not found.named.steps and not found.unknown


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_a_law_beside_a_bow_is_no_map_that_follows_both(seed):
    """A wall that bows with the square of the place is as a distortion of the disparity, at whatever distance.

    Not of all seeds: with 1 a banding of a few steps takes the distortion's part.
    """
    distances, blocks = (0.7, 0.85, 1.0, 1.25, 1.6, 2.0, 2.5, 3.0), []
    bows: list[float] = []
    sensor = sensor_of("structured_light", DisparityOffset(offset=-0.04))
    for block, distance in zip(looks_at(sensor, seed, [(z, 0, 0) for z in distances]), distances, strict=True):
        x, y = (block.view.camera.rays()[..., axis] * distance for axis in (0, 1))
        stage = SimpleNamespace(**{**vars(block.stage), "mesh_sigma_m": None, "shape": "wall"})
        T_world_camera = np.eye(4)
        T_world_camera[2, 3] = -distance
        bow = BOW_M * (2.0 * (x**2 - y**2) + np.sin(3.0 * x + seed))
        blocks.append(replace(block, mean=block.mean + bow, stage=stage, T_world_camera=T_world_camera))
        bows.append(np.sqrt(np.mean((bow - bow.mean()) ** 2)))
    found = explained_looks(blocks, sensor_of("structured_light"))
    assert [step.effect.name for step in found.named.steps] == ["disparity_offset"]
    told = nuisances_of(
        found.before, found.covariance, found.white_left
    ).shape_rms_m  # of the bow, and not of what the law explains
    assert 0.5 < told / np.sqrt(np.mean(np.square(bows))) < 2.0
    assert not found.unknown


@pytest.mark.slow
def test_a_law_is_named_though_poses_are_worse_than_stated():
    blocks = worse_posed(sensor_of("itof", DepthScale(scale=0.05)), 1)
    found = explained_looks(blocks, sensor_of("itof"))
    assert [step.effect.name for step in found.named.steps] == ["depth_scale"]
    assert found.posterior >= CONFIDENCE


def test_a_setting_competes_with_laws():
    observations = observe(sensor_of("itof"), worse_posed(sensor_of("itof"), 2))
    covariance = covariance_of(observations)
    setting = without_laws(observations, covariance)
    assert setting.observations.loose.pose > WORSE / 2
    assert posterior(with_laws(observations, covariance, 50.0), setting) < 1e-6
    assert posterior(setting, setting) == pytest.approx(0.5)


def test_shapes_that_were_stated_have_no_free_size():
    said = observe(sensor_of("itof"), bowed(1, said=0.001))
    assert [part.shape[1] for part in shape_columns(said) + room_columns(said)] == [0, 0, 0, 0]
    unsaid = observe(sensor_of("itof"), bowed(1))
    assert all(part.shape[1] > len(WALLS) for part in shape_columns(unsaid))


def test_one_room_bends_alike_in_every_mesh():
    unsaid = observe(sensor_of("itof"), bowed(1))
    assert all(part.shape[1] > 1 for part in room_columns(unsaid))
    one = [replace(k, stage=SimpleNamespace(**{**vars(k.stage), "shape": "one"})) for k in bowed(1)]
    # of one mesh it is what its own shape is
    assert [part.shape[1] for part in room_columns(observe(sensor_of("itof"), one))] == [0, 0]


def larger(seed, by, off):
    """Blocks at walls of a mesh that is too small by a share about the camera, and stands off by a shift [m]."""
    out = []
    for block in looks_at(sensor_of("itof"), seed):
        stage = SimpleNamespace(**{**vars(block.stage), "caster": "a mesh"})
        depth = block.view.depth
        change = by * depth + moved_rigidly(depth, np.array([0, 0, 0, *off]), block.view)
        out.append(replace(block, mean=block.mean + change, stage=stage))
    return out


def test_a_mesh_of_another_size_is_found():
    observations = observe(sensor_of("itof"), larger(1, 0.0, (0.002, 0.0, -0.03)))
    setting = without_laws(observations, covariance_of(observations))
    white = setting.covariance.whiten(setting.observations.residual)
    assert float(white @ white) / len(white) < 1.3
    scale, off = mesh_off(setting.observations, setting.covariance.pulled(white))
    assert abs(scale) < 0.004
    assert off == pytest.approx(0.026, rel=0.15)  # 30 mm along the axis, seen along the normals
    right = observe(sensor_of("itof"), larger(1, 0.0, (0.0, 0.0, 0.0)))
    assert without_laws(right, covariance_of(right)).observations.loose.mesh == 0.0


def test_a_camera_file_that_is_wrong_is_found():
    # depth that the device made with its own camera, read with another
    blocks = []
    for block in looks_at(sensor_of("itof"), 1):
        depth, stated = block.view.depth, block.view.camera
        device = replace(stated, cx=stated.cx - 3.0, fx=stated.fx / 1.01, fy=stated.fy / 1.01)
        change = seen_along(depth, device.rays(), block.view) - depth
        stage = SimpleNamespace(**{**vars(block.stage), "caster": "a mesh"})
        blocks.append(replace(block, mean=block.mean + change, stage=stage))
    observations = observe(sensor_of("itof"), blocks)
    setting = without_laws(observations, covariance_of(observations))
    found = file_error(
        setting.observations, setting.covariance.pulled(setting.covariance.whiten(setting.observations.residual))
    )
    assert found.cx == pytest.approx(3.0, abs=0.5)
    assert found.cy == pytest.approx(0.0, abs=0.5)
    assert found.focal == pytest.approx(0.01, abs=0.003)


def test_the_size_of_bows_is_told():
    observations = observe(sensor_of("itof"), bowed(1))
    setting = without_laws(observations, covariance_of(observations))
    white = setting.covariance.whiten(setting.observations.residual)
    assert 0.5 * BOW_M < bent_m(setting.observations, setting.covariance.pulled(white)) < 2 * BOW_M


def test_sizes_are_found_together():
    rng = np.random.default_rng(3)
    first, second = rng.standard_normal((600, 40)), rng.standard_normal((600, 60))
    white = 1.2 * rng.standard_normal(600) + first @ rng.normal(0, 2.0, 40) + second @ rng.normal(0, 0.3, 60)
    found = sizes_of(white, [first, second, np.zeros((600, 0))], 600)
    # 40 and 60 draws tell a variance to 22 and 18 %
    assert found.variances[0] == pytest.approx(4.0, rel=0.6)
    assert found.variances[1] == pytest.approx(0.09, rel=0.6)
    assert found.variances[2] == 0.0
    assert found.noise == pytest.approx(1.44, rel=0.25)


def test_a_size_that_is_not_asked_for_stays_zero():
    rng = np.random.default_rng(4)
    found = sizes_of(rng.standard_normal(500), [rng.standard_normal((500, 30))], 500)
    assert found.variances == (0.0,)


def test_a_setting_beside_some_laws_leaves_to_a_drift_what_all_of_them_do():
    """Else a mesh that is off pays for what the frames do by themselves, and a law for it does not."""
    given = sensor_of("itof")
    better = given.having(DepthOffset(offset=0.003)).having(CyclicError(amplitude=0.002))
    seen = replace(observe(given, larger(1, 0.0, (0.0, 0.0, -0.02))), loose=Loose(drift=0.001))
    steps = [SimpleNamespace(effect=effect, price=7.0) for effect in better.effects[-2:]]
    named = SimpleNamespace(steps=steps, sensor=better)
    mean = SimpleNamespace(
        seen=SimpleNamespace(observations=seen, covariance=covariance_of(seen)), named=named, beyond=None
    )
    settings = list(_beside_parts(mean, given))
    assert len(settings) == 2
    assert all(setting.observations.loose.drift == 0.001 for setting in settings)
    assert any(setting.observations.loose.mesh for setting in settings)
