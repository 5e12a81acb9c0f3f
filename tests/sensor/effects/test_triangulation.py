"""Effects of triangulation against what geometry says without them."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.effects.triangulation.projector_thermal_drift import ProjectorThermalDrift
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.effects.triangulation.vertical_banding import VerticalBanding
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, View

CAMERA = Camera(96, 64, 90.0, 90.0, 47.5, 31.5, principle="structured_light")
FB = 43.5  # [px m], a Kinect v1's


def wall(z: float, **moment) -> View:
    return View(CAMERA, np.full(CAMERA.shape, z), baseline=FB / CAMERA.fx, moment=Moment(**moment))


def shift(effect, view: View) -> np.ndarray:
    """Change of the disparity [px] (h, w) that a bias stands for."""
    return FB / (view.depth + effect.bias(view.depth, view)) - FB / view.depth


def test_a_tenth_of_a_pixel_is_nine_millimetres_at_two_metres():
    error = DisparityOffset(0.1).bias(np.full((1, 1), 2.0), wall(2.0))
    assert error[0, 0] == pytest.approx(-0.0092, abs=5e-5)  # half the last digit


@pytest.mark.parametrize("place", [-0.075, 0.075])
def test_a_warm_grating_is_decoded_as_geometry_says(place):
    camera = Camera(640, 480, 580.0, 580.0, 319.5, 239.5)
    rng = np.random.default_rng(0)
    z = rng.uniform(0.6, 4.0, camera.shape)
    view = View(camera, z, baseline=place, moment=Moment(temperature=35.0))
    scale = 1 + 2e-4 * 10
    # the dot on each point, by the sines of its angles, which the grating gives in proportion to the wavelength
    x, y = np.moveaxis(camera.rays().astype(float), -1, 0)
    way = np.stack([x * z - place, y * z, z])
    sines = (way / np.linalg.norm(way, axis=0))[:2] / scale
    cold = sines[0] / np.sqrt(1 - (sines**2).sum(axis=0))
    # where the camera's ray meets the upright plane in which the chip believes that dot
    believed = place / (x - cold)
    bias = ProjectorThermalDrift(2e-4).bias(z, view)
    # the law is of first order in the warming of 0.2 %, the geometry of all
    assert np.abs(bias - (believed - z)).max() < 0.01 * np.abs(bias).max()


def test_a_degree_moves_the_edge_of_the_field_by_a_tenth_of_a_pixel():
    camera = Camera(640, 480, 580.0, 580.0, 319.5, 239.5)
    view = View(camera, np.full(camera.shape, 4.0), baseline=0.075, moment=Moment(temperature=26.0))
    z = view.depth
    moved = 43.5 / (z + ProjectorThermalDrift(3.6e-4).bias(z, view)) - 43.5 / z
    assert moved[240, -1] == pytest.approx(0.1, rel=0.6)  # known as up to 0.1 px/K
    assert np.abs(moved[240, 322:324]).max() < 0.01  # the middle of the pattern stays
    assert np.all(np.diff(moved[240]) > 0)  # grows from the axis on both sides


def test_without_a_temperature_nothing_drifts():
    assert not np.any(ProjectorThermalDrift(1e-3).bias(np.full(CAMERA.shape, 2.0), wall(2.0)))


def test_a_bar_grows_by_half_a_window_on_each_side():
    u = np.arange(CAMERA.width)[None, :] + np.zeros(CAMERA.shape)
    left, right, near, far = 40.3, 55.8, 1.0, 1.5
    inside = (u > left) & (u < right)
    distance = np.where(inside, np.minimum(u - left, right - u), np.maximum(left - u, u - right))
    jump = np.where(inside, far - near, near - far)
    depth = np.where(inside, near, far)
    view = replace(wall(1.0), depth=depth, edges=Edges(distance, np.zeros_like(u), jump, np.ones_like(u)))
    for window in (1.0, 5.0, 9.0):
        measured = depth + EdgeFattening(window).bias(depth, view)
        assert np.all(measured[inside] == near)
        width = ((far - measured) / (far - near)).sum(axis=1)
        # a pixel at either end is as far off as the edge is from the middle between two pixels
        assert np.abs(width - (right - left + window)).max() < 1.0
        assert np.all(measured[:, np.array([int(left - window / 2) - 1, int(right + window / 2) + 3])] == far)


def test_fattening_needs_known_edges_and_survives_unknown_jumps():
    view = wall(1.0)
    assert not np.any(EdgeFattening(9.0).bias(view.depth, view))
    none = Edges(*(np.full(CAMERA.shape, np.nan) for _ in range(4)))
    assert not np.any(EdgeFattening(9.0).bias(view.depth, replace(view, edges=none)))


def test_a_warp_grows_with_the_square_of_the_depth_and_fades_with_the_disparity():
    warp = np.random.default_rng(0).uniform(-0.2, 0.2, CAMERA.shape)
    effect = DisparityDistortion(map=warp)
    assert np.allclose(shift(effect, wall(1.0)), warp) and np.allclose(shift(effect, wall(3.0)), warp)
    near, far = (shift(DisparityDistortion(map=warp, decay=0.02), wall(z)) for z in (1.0, 3.0))
    assert np.allclose(near / far, np.exp(-0.02 * (FB - FB / 3)))


def test_the_polynomial_has_no_offset_and_no_tilt():
    view = wall(2.0)
    u, v = (view.u + 0.5) / CAMERA.width * 2 - 1, (view.v + 0.5) / CAMERA.height * 2 - 1
    terms = [u**2, u * v, v**2, u**3, u**2 * v, u * v**2, v**3]
    for k, term in enumerate(terms):
        coefficients = [0.0] * k + [0.1]
        # the disparity is found as a difference of numbers of 20 px in float32
        assert np.allclose(shift(DisparityDistortion(coefficients=coefficients), view), 0.1 * term, atol=1e-5)
    assert np.allclose(shift(DisparityDistortion(coefficients=0.1), view), 0.1 * terms[0], atol=1e-5)


def test_the_size_of_a_frozen_warp_is_kept_and_its_spread_over_units_declared():
    effect, one = DisparityDistortion(rms=0.2), wall(2.0, unit=1)
    assert np.sqrt((shift(effect, one) ** 2).mean()) == pytest.approx(0.2, rel=1e-4)
    assert np.array_equal(effect.bias(one.depth, one), effect.bias(one.depth, wall(2.0, unit=1)))
    assert not np.any(effect.bias(one.depth, wall(2.0)))
    # 200 units: 4.5 standard errors of a standard deviation, 5 % each, for the worst of 24; small warps, where the
    # depth is linear in them
    small = DisparityDistortion(rms=0.01)
    biases = np.array([small.bias(one.depth, wall(2.0, unit=k))[::16, ::16] for k in range(200)])
    assert np.abs(biases.std(axis=0) / small.noise(one.depth, one)[::16, ::16] - 1).max() < 0.225


def test_locking_has_its_period_in_the_disparity():
    d = np.linspace(10, 12, CAMERA.width)[None, :] + np.zeros(CAMERA.shape)
    view = replace(wall(1.0), depth=FB / d)
    error = shift(PixelLocking(0.05), view)
    assert np.allclose(error, 0.05 * np.sin(2 * np.pi * d), atol=1e-9)
    halved = shift(PixelLocking(0.05, period=0.5), view)
    assert np.allclose(halved, 0.05 * np.sin(4 * np.pi * d), atol=1e-9)


@pytest.mark.parametrize(("amplitude", "period", "undone"), [(0.06, 1.0, True), (-0.03, 0.5, True), (0.2, 1.0, False)])
def test_locking_is_undone_while_its_fringes_do_not_fold(amplitude, period, undone):
    sensor = Sensor(effects=(PixelLocking(amplitude, period),), baseline=FB / CAMERA.fx)
    depth = np.linspace(0.6, 4.0, CAMERA.width * CAMERA.height).reshape(CAMERA.shape)
    measured = sensor.predict(depth, CAMERA)
    back = sensor.correct(measured, CAMERA)
    assert bool(sensor.left_out) != undone
    assert np.abs(back - depth).max() < 1e-5 if undone else np.array_equal(back, measured)


def test_known_bands_are_jumps_at_their_columns():
    effect = VerticalBanding(columns=[20.0, 60.0], steps=[0.1, -0.25])
    error = shift(effect, wall(2.0))
    for columns, expected in ((slice(0, 21), 0.0), (slice(21, 61), 0.1), (slice(61, None), -0.15)):
        assert np.allclose(error[:, columns], expected)
    assert np.all(error == error[0])
    # one step for all columns
    assert np.allclose(shift(VerticalBanding(columns=[20.0, 60.0], steps=0.1), wall(2.0))[:, 70:], 0.2)


def test_unknown_bands_are_frozen_and_as_large_as_declared():
    effect = VerticalBanding(step=0.01)
    view = wall(2.0, unit=4)
    error = shift(effect, view)[0]
    sizes = np.abs(np.diff(error))
    assert np.allclose(sizes[sizes > 1e-6] / 0.01, np.round(sizes[sizes > 1e-6] / 0.01), atol=1e-6)
    assert 1 <= (sizes > 1e-6).sum() <= 8 and abs(error.mean()) < 1e-9
    biases = np.array([effect.bias(view.depth, wall(2.0, unit=k))[0] for k in range(600)])
    declared = np.broadcast_to(effect.noise(view.depth, view), CAMERA.shape)[0]
    # 4 standard errors of 600 units, 3 % each
    assert np.abs(biases.std(axis=0) / declared - 1).max() < 0.12
    assert not np.any(effect.bias(view.depth, wall(2.0)))


def test_speckle_stays_while_the_scene_stands_still():
    sensor = Sensor(effects=(SpeckleNoise(sigma_px=0.1, correlation_px=2.0),), baseline=FB / CAMERA.fx)
    rng = np.random.default_rng(0)
    still, moved = wall(2.0, placement=1), wall(2.0, placement=2)
    frames = [sensor.sample(still.depth, still, None, rng) - 2.0 for _ in range(3)]
    assert np.array_equal(frames[0], frames[1]) and np.array_equal(frames[0], frames[2])
    other = sensor.sample(moved.depth, moved, None, rng) - 2.0
    # neighbours over 2 px share their grain: some 300 independent ones, so 4 standard errors are a quarter
    assert abs(np.corrcoef(frames[0].ravel(), other.ravel())[0, 1]) < 0.25
    expected = 0.1 * 2.0**2 / FB
    assert frames[0].std() == pytest.approx(expected, rel=0.25)
    assert np.allclose(sensor.sigma(still.depth, None, CAMERA), expected)
    # a window of 2 px shares half of it with its neighbour
    assert np.corrcoef(frames[0][:, 1:].ravel(), frames[0][:, :-1].ravel())[0, 1] == pytest.approx(0.5, abs=0.1)
