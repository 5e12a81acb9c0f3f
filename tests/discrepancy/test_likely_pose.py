"""Poses that are off by centimetres: depth is not linear in them, and what is not is no error of the sensor."""

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.likely_pose import at_likely_poses
from fusion.discrepancy.observe.observations import observe
from fusion.geometry.pose import exp
from fusion.sensor.laws.surface import moved_beyond, moved_rigidly, seen_along

FAR = 12.0  # mm and mrad


def chi2(observations) -> float:
    white = covariance_of(observations).whiten(observations.residual)
    return float(white @ white / len(white))


def test_what_a_motion_changes_is_its_first_order_and_the_rest():
    block = looks_at(sensor_of("itof"), 0)[1]
    motion = np.array([0.01, -0.02, 0.005, 0.004, -0.003, 0.01])
    whole = seen_along(block.view.depth, block.view.camera.rays(), block.view, exp(motion)) - block.view.depth
    first = moved_rigidly(block.view.depth, 1e-4 * motion, block.view) * 1e4
    beyond = moved_beyond(block.view.depth, motion, block.view)
    # the first order is that of a motion of 1e-3, so half a thousandth of it is not: of up to 60 mm
    np.testing.assert_allclose(beyond, whole - first, atol=5e-5)
    # of a motion half as large a quarter is left
    half = moved_beyond(block.view.depth, motion / 2, block.view)
    assert abs(np.nanmedian(half / beyond) - 0.25) < 0.02


def test_walls_far_from_where_they_are_said_to_be_fit_once_they_are_looked_at_from_their_likely_poses():
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 3, off=FAR)
    observations = observe(sensor, blocks)
    moved = at_likely_poses(blocks, observations, covariance_of(observations))
    # some 200 tiles: a chi2 per tile of 1 to a tenth
    assert chi2(observations) > 1.3 and chi2(observations.seen_again(moved)) < 1.15


def test_nothing_is_missing_where_poses_are_far_off():
    found = explained_looks(looks_at(sensor_of("itof"), 3, off=FAR), sensor_of("itof"))
    assert not found.named.steps and not found.unknown


def test_poses_that_are_nearly_right_stay():
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 0)
    observations = observe(sensor, blocks)
    assert at_likely_poses(blocks, observations, covariance_of(observations)) == blocks
