"""Errors of camera and depth, and the views that they change."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.turntable.selfcheck import NAMES, PRIOR, DepthKnown, SelfCheck
from fusion.turntable.selfcheck import prior_of as prior_at
from fusion.turntable.views import ObjectView

CAMERA = Camera(40, 30, 50.0, 52.0, 19.0, 15.0)


def a_view(seed=0):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.6, 1.0, CAMERA.shape).astype(np.float32)
    points = CAMERA.points(depth)
    normals = np.tile(np.float32([0, 0, -1]), (*CAMERA.shape, 1))
    sigma = np.full(CAMERA.shape, 0.001, np.float32)
    flat = points.reshape(-1, 3)[::7]
    return ObjectView(PointMap(CAMERA, points, normals, sigma), flat, normals.reshape(-1, 3)[::7], sigma.ravel()[::7])


def test_no_errors_change_nothing():
    nominal = a_view()
    same = SelfCheck(np.zeros(len(NAMES)), 0.6, 1.0).view(nominal)
    assert np.allclose(same.points, nominal.points, atol=1e-6)
    assert np.allclose(same.map.points, nominal.map.points, atol=1e-6)
    assert same.map.camera == CAMERA


def test_corrected_points_project_to_the_pixels_they_came_from():
    values = np.array([0.02, 3.0, -2.0, 0.005, 0.03, 0.01, -0.02, 0.001, 0.002, -0.001, 0.001, 0.0, 0.001])
    new = SelfCheck(values, 0.6, 1.0).view(a_view()).map
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    pixels = new.camera.project(new.points.reshape(-1, 3))
    assert pixels == pytest.approx(np.column_stack([u.ravel(), v.ravel()]), abs=1e-3)  # float32 points


def test_points_and_view_agree():
    values = np.array([0, 0, 0, 0.005, 0.03, 0.01, -0.02, 0.001, 0.002, -0.001, 0.001, 0.0, 0.001])
    check, nominal = SelfCheck(values, 0.6, 1.0), a_view()
    points = nominal.map.points.reshape(-1, 3).copy()
    points[:5] = np.nan
    corrected = check.points(points)
    assert np.isnan(corrected[:5]).all()
    assert corrected[5:] == pytest.approx(check.view(nominal).map.points.reshape(-1, 3)[5:], abs=1e-6)


def test_only_the_named_errors_are_taken_over():
    check = SelfCheck(np.linspace(0.01, 0.1, len(NAMES)), 0.6, 1.0).only("focal")
    camera = check.camera(CAMERA)
    assert (camera.cx, camera.cy) == (CAMERA.cx, CAMERA.cy)
    assert camera.fx == pytest.approx(CAMERA.fx * np.exp(0.01)) and camera.fy == pytest.approx(CAMERA.fy * np.exp(0.01))
    assert not check.values[1:].any()


POINTS = np.column_stack([np.random.default_rng(1).uniform(-0.2, 0.2, (50, 2)), np.linspace(0.6, 1.0, 50)])
RANGE = SelfCheck(np.zeros(len(NAMES)), 0.6, 1.0)


def prior_of(camera, known):
    """(13,) for some points."""
    return prior_at(camera, known, POINTS, RANGE)


def test_a_calibration_narrows_what_may_be_wrong():
    assert np.array_equal(prior_of(CAMERA, None), PRIOR)
    known = replace(CAMERA, std={"fx": 0.01, "fy": 0.01, "cx": 0.1, "cy": 0.2})
    narrow = prior_of(known, DepthKnown(0.0005))
    tilts = np.isin(NAMES, ["tilt_u", "tilt_v"])  # which walls at a free tilt leave open
    assert (narrow < PRIOR)[~tilts].all() and (narrow > 0).all() and (narrow == PRIOR)[tilts].all()
    assert narrow[0] < 0.001 and narrow[NAMES.index("offset")] == 0.0005
    assert (prior_of(known, DepthKnown(1.0))[3:] == PRIOR[3:]).all()  # never wider than that of a nominal camera


def test_boards_narrow_the_tilts_too():
    over_u, over_v = prior_of(CAMERA, DepthKnown(0.001, tilt=(0.0, 0.010)))[
        [NAMES.index("tilt_u"), NAMES.index("tilt_v")]
    ]
    assert 0.001 < over_u < 0.003  # what the law leaves at an image's corner remains
    assert 0.010 < over_v < 0.011


def test_a_calibration_that_keeps_its_errors_is_taken_at_its_word():
    tilted, bent = 0.004 * RANGE.depth_terms(POINTS)[:, 2], 0.001 * RANGE.depth_terms(POINTS)[:, 5]
    known = DepthKnown(0.1, errors=lambda points: np.array([tilted + bent, 2 * bent]))
    prior = dict(zip(NAMES, prior_of(CAMERA, known), strict=True))
    assert prior["tilt_u"] == pytest.approx(0.004) and prior["bend2"] == pytest.approx(np.sqrt(5) * 0.001)
    assert max(prior[name] for name in ("offset", "radial", "tilt_v", "stretch", "bend3")) < 1e-8
    assert prior["focal"] == PRIOR[0]


def test_errors_of_depth_are_told_by_name():
    assert SelfCheck(np.zeros(len(NAMES)), 0.6, 1.0).depth_errors() == {}
    values = np.zeros(len(NAMES))
    values[[NAMES.index("focal"), NAMES.index("tilt_u")]] = 0.1, 0.02
    told = SelfCheck(values, 0.6, 1.0).depth_errors()
    assert told["tilt_u"] == 0.02 and told["bend6"] == 0 and "focal" not in told
    assert (told["near"], told["far"]) == (0.6, 1.0)
