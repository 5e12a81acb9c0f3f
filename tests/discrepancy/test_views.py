"""Views of one recording stand for recordings where they are far enough apart; its frames each have their time."""

from dataclasses import replace

import numpy as np
from made_up_walls import WALLS, look_at, sensor_of

from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.placements import views_of
from fusion.geometry.pose import about_axis
from fusion.sensor.effects.phase.sensor_interference import SensorInterference


def test_a_turned_camera_sees_another_view_and_a_shaken_one_does_not():
    turned = [about_axis((0.0, 0.0, 0.8), (0.0, 1.0, 0.0), np.deg2rad(angle)) for angle in (0, 1, 30, 31, 60, 0.5)]
    assert views_of(turned) == [0, 0, 1, 1, 2, 0]
    shaken = [np.eye(4) + np.diag([1e-3] * 3, 1) for _ in range(5)]
    assert set(views_of(shaken)) == {0}
    assert views_of([]) == []


def test_a_beat_is_its_mean_over_the_frames_and_a_part_of_their_spread():
    sensor, effect = sensor_of("itof"), SensorInterference(fraction=0.02, beat=0.1)
    times = (100.0, 102.0, 104.0, 106.0)
    (patch,) = observe(sensor, [replace(look_at(sensor, 0, WALLS[0], 0), times=times)]).patches
    moments = [replace(patch.view, moment=replace(patch.view.moment, time=time)) for time in times]
    single = np.array([effect.change(patch.depth, view) for view in moments])
    usual = patch.tiles.mean(single.mean(axis=0) * patch.native)
    assert np.abs(usual).max() > 1e-4
    np.testing.assert_allclose(patch.column(effect), usual, rtol=1e-6)
    better = patch.under(sensor.having(effect))
    np.testing.assert_allclose(patch.tiles.mean((better.predicted - patch.predicted) * patch.native), usual, rtol=0.02)
    shot = effect.noise(patch.depth, patch.view)
    whole = np.sqrt(patch.sigma**2 + shot**2 + single.std(axis=0) ** 2)
    assert np.nanmedian(np.abs(better.sigma / whole - 1)) < 0.01
