"""What a free pose would swallow: on planes, every error of the disparity that is affine in the image."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.inference.identifiability import unseen, visibilities
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.laws.surface import moved_rigidly
from fusion.sensor.parameter import parameters


def survival(observations, column: np.ndarray) -> float:
    """Share of a column that is left when every recording's pose is free."""
    left = []
    for rows, patch in observations.rows():
        moves = [moved_rigidly(patch.depth, 1e-7 * np.eye(6)[k], patch.view) * patch.native for k in range(6)]
        poses = np.column_stack([patch.tiles.mean(move) for move in moves])
        basis = np.linalg.svd(poses, full_matrices=False)
        span = basis[0][:, basis[1] > 1e-6 * basis[1][0]]
        left.append(column[rows] - span @ (span.T @ column[rows]))
    return float(np.linalg.norm(np.concatenate(left)) / np.linalg.norm(column))


def test_scale_offset_and_tilt_of_a_triangulating_sensor_vanish_on_walls_with_free_poses():
    sensor = sensor_of("structured_light")
    observations = observe(sensor, looks_at(sensor, 0))
    small = [DepthScale(scale=1e-7), DisparityOffset(offset=1e-7)]
    tilt = np.concatenate([p.tiles.mean(np.broadcast_to(p.view.u, p.depth.shape)) for p in observations.patches])
    columns = [*observations.columns(small).T, tilt]
    for column in columns:
        assert survival(observations, column) < 1e-6
    # and what is not affine stays to be seen
    assert survival(observations, observations.columns([PixelLocking(amplitude=0.01)])[:, 0]) > 0.3


def table_of(sensor, blocks):
    """What the engine says of every effect, by name."""
    observations = observe(sensor, blocks)
    covariance = covariance_of(observations)
    return {entry.effect: entry for entry in visibilities(candidates_of(observations, covariance), covariance)}


def test_the_table_says_what_nearly_free_poses_swallow():
    sensor = sensor_of("structured_light")
    blocks = [free_pose(block) for block in looks_at(sensor, 0)]
    table = table_of(sensor, blocks)
    for name in ("depth_scale", "disparity_offset"):
        assert not table[name].visible and name in unseen(list(table.values()), "structured_light")
    assert table["pixel_locking"].visible_share > 0.3


def test_what_only_sizes_that_next_to_no_sensor_has_would_show_is_not_visible():
    sensor = sensor_of("itof")
    noisy = [replace(block, std=30 * block.std) for block in looks_at(sensor, 0)]
    table = table_of(sensor, noisy)
    told = [entry for entry in table.values() if entry.visible]
    for entry in told:  # the typical size, to the factor 3 by which sizes differ, in 19 cases of 20
        kind = next(kind for kind in EFFECTS if kind.name == entry.effect)
        about = next(
            one for one in parameters(kind).values() if one.label == entry.parameter and one.unit == entry.unit
        )
        assert entry.detectable <= 6.2 * about.typical
    # of others as much survives, and they do not stand out
    assert told and any(entry.visible_share > 0.5 and not entry.visible for entry in table.values())


def free_pose(block):
    """A block whose pose is known to a few metres and half a radian."""
    stage = SimpleNamespace(**{**vars(block.stage), "sigma_m": 3.0, "sigma_rad": 0.5})
    return replace(block, stage=stage)


def test_the_smallest_detectable_size_stands_out_by_five_sigma():
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 0)
    entry = table_of(sensor, blocks)["depth_scale"]
    observations = observe(sensor, blocks)
    white = covariance_of(observations).whiten(observations.columns([DepthScale(scale=entry.detectable)])[:, 0])
    # the footprint is linear to first order; its size here is a part in ten thousand
    assert abs(np.linalg.norm(white) - 5) < 0.05


def test_twins_of_this_data_are_named():
    """A path inside the material and an offset are both lengths: no wall tells them apart."""
    table = table_of(sensor_of("itof"), looks_at(sensor_of("itof"), 0))
    assert "subsurface_scattering" in table["depth_offset"].looks_like
    assert "column_delay" not in table["depth_offset"].looks_like


def test_what_only_an_impossible_size_would_show_is_not_visible():
    """A table can move by what noise hides if only the size is beyond every bound: that shows nothing."""
    sensor = sensor_of("itof")
    observations = observe(sensor, looks_at(sensor, 0))
    covariance = covariance_of(observations)
    offset = next(c for c in candidates_of(observations, covariance) if c.name == "depth_offset" and not c.where)
    for faint, seen in ((1.0, True), (1e-6, False)):
        weak = replace(offset, columns=offset.columns * faint, white=offset.white * faint)
        (entry,) = visibilities([weak], covariance)
        assert entry.visible == seen and (entry.detectable is not None) == seen
