"""What a calibration leaves of errors of depth: as large as what it says, and kept in its file."""

import json
from dataclasses import replace

import numpy as np
import pytest
from test_depth_calibration import DISTANCES, SL, TOF, _Recording, calibrated, with_boards

from fusion.calibration.depth.calibration import calibrate_walls
from fusion.calibration.depth.known import start
from fusion.errors import SensorError
from fusion.sensor.correction.unit import depth_std
from fusion.sensor.depth_errors import DepthErrors
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.sensor import Sensor

LAW = DepthScale(0.01), DisparityOffset(0.4)


def test_errors_are_as_large_as_is_said():
    """Of 16 calibrations by 17 walls, whose lasers err; on the axis, as free tilts leave the rest open."""
    ratios = []
    for seed in range(16):
        found, true = calibrated(SL, LAW, seed=seed), Sensor(principle=SL.principle, effects=LAW)
        for z in (0.8, 1.2, 1.6, 2.1):
            depth = np.full(SL.shape, z)
            off = found.sensor.correct(true.predict(depth, SL), SL) - depth
            ratios.append(off[36, 48] / np.linalg.norm(found.sensor.depth_errors.at(48, 36, z)))
    # never surer than right by more than such few numbers tell; too careful by up to five times, as walls of one kind
    # of noise leave other laws open that real walls would not
    assert 0.2 < np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_errors_beyond_the_walls_are_as_large_as_is_said(monkeypatch):
    """Of walls between 1.4 and 1.6 m, where scale and disparity do the same, cameras of usual errors."""
    monkeypatch.setattr("test_depth_calibration.DISTANCES", np.linspace(1.4, 1.6, 6))
    ratios, rng = [], np.random.default_rng(11)
    for seed in range(16):
        effects = DepthScale(rng.normal(0, 0.005)), DisparityOffset(rng.normal(0, 0.1))
        found, true = calibrated(SL, effects, seed=seed), Sensor(principle=SL.principle, effects=effects)
        if found.left is None:  # the two take each other at the walls
            continue
        for which in (0, -1):
            depth = np.full(SL.shape, found.left.distance[which])
            off = found.sensor.correct(true.predict(depth, SL), SL) - depth
            ratios.append(off[36, 48] / found.left.std[which])
    assert len(ratios) > 16
    assert 0.3 < np.sqrt(np.mean(np.square(ratios))) < 1.4  # 4 to 40 times as large as by the law's numbers alone


def test_numbers_that_hold_each_other_are_known_better_together():
    sensor = calibrated(SL, LAW).sensor
    alone = replace(sensor, depth_errors=None)
    assert depth_std(sensor, SL, 1.5) < 0.3 * depth_std(alone, SL, 1.5)


def test_what_walls_cannot_show_may_be_of_its_usual_size():
    """A delay over the chip, 3e-5 m/px, which free tilts hide: nothing on the axis, 1.4 mm at 48 px from it."""
    errors = calibrated(TOF, (DepthOffset(0.01),)).sensor.depth_errors
    edge, axis = (np.linalg.norm(errors.at(u, TOF.cy, 1.0)) for u in (TOF.width - 1, TOF.cx))
    assert edge > 1.2e-3 and axis < 2e-4


def test_boards_tell_a_pattern_that_lies_askew():
    v, u = np.mgrid[: SL.height, : SL.width]
    askew = 0.3 * (u - SL.cx) / SL.width - 0.2 * (v - SL.cy) / SL.height
    effects = DepthScale(0.01), DisparityDistortion(map=askew)
    found = calibrate_walls(with_boards(SL, effects), start([_Recording(SL)], None, None), surface=False)
    assert "tilt" in found.best.candidate.name
    warp = found.sensor.effect("disparity_distortion")
    assert isinstance(warp, DisparityDistortion)
    # tilts of twelve boards are known to 2e-3 each: 0.04 px at an edge of the image together, four deviations
    assert np.abs(warp.map - askew).max() < 0.04
    walls = calibrated(SL, effects)
    assert "tilt" not in walls.best.candidate.name


def test_they_stand_in_the_file(tmp_path):
    sensor = calibrated(SL, LAW).sensor
    write_sensor(tmp_path / "sensor.json", sensor)
    again = read_sensor(tmp_path / "sensor.json")
    assert depth_std(again, SL, 1.3) == pytest.approx(depth_std(sensor, SL, 1.3), rel=1e-5)
    other = again.having(DepthScale(0.0))
    assert other.depth_errors is None, "they are those of the law that was fitted"
    assert again.having(DepthOffset(0.0)).depth_errors is not None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"depth_m": [1.0, 0.5]}, "increasing"),
        ({"values_m": [[[[0.1, 0.1]]]]}, "errors by the grid"),
        ({"values_m": "none.npy"}, "none.npy"),
    ],
)
def test_a_file_that_cannot_be_read_is_told(tmp_path, change, said):
    grid = np.array([0.0, 1.0])
    sensor = Sensor(effects=(DepthOffset(0.01),), depth_errors=DepthErrors(grid, grid, grid, np.zeros((1, 2, 2, 2))))
    path = tmp_path / "sensor.json"
    write_sensor(path, sensor)
    content = json.loads(path.read_text())
    content["depth_errors"] |= change
    path.write_text(json.dumps(content))
    with pytest.raises(SensorError, match=said):
        read_sensor(path)


def test_they_are_held_beyond_the_walls():
    errors = calibrated(SL, LAW).sensor.depth_errors
    far = errors.at(SL.cx, SL.cy, [2 * DISTANCES[-1], 3 * DISTANCES[-1]])
    assert (far[:, 0] == far[:, 1]).all()
