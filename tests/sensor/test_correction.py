"""The correction as the pipelines use it: what a sensor did to a view is undone, camera and conditions included."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.correction.correction import corrected_image, true_camera
from fusion.sensor.correction.summary import tell
from fusion.sensor.effects.light.subsurface_scattering import SubsurfaceScattering
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.optics.lens_distortion import LensDistortion
from fusion.sensor.effects.optics.principal_point import PrincipalPoint
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, stretch
from fusion.sensor.weights.rating import DOUBT, sigma_of, weight_of
from fusion.sensor.window import of_window

STATED = Camera(64, 48, 57.0, 57.0, 31.5, 23.5, principle="itof")
SL = replace(STATED, principle="structured_light")
RAYS = STATED.rays()
DARK = np.broadcast_to(np.linspace(300.0, 3000.0, 64, dtype=np.float32), (48, 64))


def wall(camera, n=(0.1, -0.2, -1.0), at=1.2):
    """Depth (48, 64) [m] of a plane through (0, 0, at), along a camera's rays."""
    rays = camera.rays().astype(float)
    return (n[2] * at / (n[0] * rays[..., 0] + n[1] * rays[..., 1] + n[2])).astype(np.float32)


def recorded(sensor, stated, **known):
    """What a sensor records of the wall: the true camera's rays, its errors of length, depth along the stated rays."""
    true = sensor.true_camera(stated)
    seen = wall(true)
    if sensor.principle == "itof":
        seen = seen * (stretch(true) / stretch(stated))
    view = View(stated, seen, done=frozenset({"focal_length", "principal_point", "lens_distortion"}), **known)
    return sensor.predict(seen, view), wall(true)


CAMERA_ERRORS = (FocalLength(0.02), PrincipalPoint(2.0, -1.5), LensDistortion(k1=0.05, k2=-0.08, p1=0.001))
TOF = (
    CyclicError(amplitude=np.array([0.004, 0.002]), period=np.array([0.6, 0.4]), phase=np.array([0.3, 1.0])),
    AmplitudeError(0.004, 1.0, 1000.0),
    FixedPattern(map=np.linspace(-0.003, 0.003, 48 * 64).reshape(48, 64)),
    TemperatureDrift(coefficient=0.001),
)


@pytest.mark.parametrize("camera_errors", [(), CAMERA_ERRORS], ids=["right camera", "wrong camera"])
def test_time_of_flight_is_undone_with_camera_amplitude_and_temperature(camera_errors):
    sensor = Sensor(principle="itof", effects=(*camera_errors, *TOF))
    moment = Moment(temperature=33.0)
    measured, truth = recorded(sensor, STATED, ir=DARK, moment=moment)
    assert np.abs(measured - truth).max() > 0.005
    found = corrected_image(sensor, measured, STATED, DARK, moment)
    # 10 micrometres: what `correct` promises
    assert np.abs(found - truth).max() < 1e-5
    assert true_camera(sensor, STATED) == sensor.true_camera(STATED)


def test_triangulation_is_undone_with_the_camera():
    sensor = Sensor(principle="structured_light", effects=(*CAMERA_ERRORS, DisparityOffset(0.05), DepthOffset(0.002)))
    measured, truth = recorded(sensor, SL)
    assert np.abs(corrected_image(sensor, measured, SL) - truth).max() < 1e-5  # as above
    assert true_camera(sensor, SL).fx == pytest.approx(57.0 / 1.02)


def test_a_sensor_without_effects_changes_nothing():
    depth = wall(STATED)
    depth[10, 10] = np.nan
    assert np.array_equal(corrected_image(Sensor(), depth, STATED), depth, equal_nan=True)


def test_usual_values_of_the_camera_are_not_applied():
    sensor = Sensor(principle="itof", effects=(FocalLength(0.02),), std={("focal_length", "relative"): 0.02})
    assert true_camera(sensor, STATED) == STATED
    told = tell(sensor, View(STATED, wall(STATED)))
    assert told.camera == () and any("focal_length: not corrected" in text for text in told.left)


def test_without_ir_the_amplitude_error_stays_and_that_is_said_once():
    sensor = Sensor(principle="itof", effects=TOF)
    measured = wall(STATED)
    without = corrected_image(sensor, measured, STATED, None, Moment(temperature=33.0))
    others = replace(sensor, effects=tuple(e for e in TOF if e.name != "amplitude_error"), left_out=())
    assert np.array_equal(without, corrected_image(others, measured, STATED, None, Moment(temperature=33.0)))
    told = tell(sensor, View(STATED, measured, moment=Moment(temperature=33.0)))
    assert told.left == ("amplitude_error: not corrected, the recording has no IR",)
    assert "amplitude_error" not in told.corrected and "cyclic_error" in told.corrected
    assert tell(sensor, View(STATED, measured, ir=DARK, moment=Moment(temperature=33.0))).left == ()


def test_without_a_temperature_its_drift_stays_and_that_is_said():
    told = tell(Sensor(principle="itof", effects=TOF), View(STATED, wall(STATED), ir=DARK))
    assert told.left == ("temperature_drift: not corrected, the recording has no temperature",)
    # a warm-up by time alone needs none
    warm = Sensor(principle="itof", effects=(TemperatureDrift(amplitude=0.005),))
    assert tell(warm, View(STATED, wall(STATED), moment=Moment(time=1e8))).left == ()


def test_what_cannot_be_undone_is_named_with_its_reason():
    told = tell(Sensor(principle="itof", effects=(MixedPixels(1.0),)), View(STATED, wall(STATED)))
    assert told.left == (
        "mixed_pixels: not corrected (one image does not tell how much of a pixel lies beyond an edge)",
    )
    assert told.line == "nothing to correct"


def test_a_correction_known_worse_than_the_noise_is_named():
    effects = (DepthOffset(0.02), AxialNoise(c0=0.001))
    sensor = Sensor(principle="itof", effects=effects, std={("depth_offset", "offset"): 0.005})
    told = tell(sensor, View(STATED, wall(STATED)))
    # rays lean by up to 35 deg, so that 5 mm along the ray are a little less in depth
    assert len(told.doubtful) == 1 and "depth_offset: corrected, but known to 4." in told.doubtful[0]
    assert tell(replace(sensor, std={("depth_offset", "offset"): 0.0005}), View(STATED, wall(STATED))).doubtful == ()


def test_a_frame_without_depth_tells_and_corrects_nothing():
    nothing = np.full(STATED.shape, np.nan, np.float32)
    sensor = Sensor(principle="itof", effects=TOF)
    found = corrected_image(sensor, nothing, STATED)
    assert np.isnan(found).all() and np.isnan(sigma_of(sensor, View(STATED, found))).all()
    assert not weight_of(sensor, View(STATED, found)).any()
    assert tell(sensor, View(STATED, nothing)).corrected == {}


def test_weight_is_that_of_the_sensor_away_from_edges():
    sensor = Sensor(principle="itof", effects=(AxialNoise(c0=0.001, c2=0.0005, angle=0.0002), SubsurfaceScattering()))
    depth = wall(STATED)
    incidence = np.full(depth.shape, 0.4, np.float32)
    expected = sensor.weight(depth, incidence, STATED)
    assert np.allclose(weight_of(sensor, View(STATED, depth, incidence)), expected, rtol=1e-5)


def step_image():
    depth = np.full(STATED.shape, 1.5, np.float32)
    depth[12:36, 20:44] = 1.0
    return depth


def test_the_rim_of_near_things_has_little_weight_where_windows_match():
    sensor = Sensor(principle="structured_light", effects=(EdgeFattening(window_px=5.0), AxialNoise(c0=0.001)))
    weight = weight_of(sensor, View(SL, step_image()))
    # half a window of 5 px covers 2.5 px: three columns whose middles lie 0.5, 1.5 and 2.5 px inside
    full = np.float32(1e6)
    assert np.allclose(weight[24, [20, 21, 22, 41, 42, 43]], DOUBT * full)
    assert np.allclose(weight[24, 23:41], full) and np.allclose(weight[24, :20], full)


def test_pixels_that_mix_both_sides_have_little_weight():
    sensor = Sensor(principle="itof", effects=(MixedPixels(fill=1.0), AxialNoise(c0=0.001)))
    lost = weight_of(sensor, View(STATED, step_image())) < 2e6 * DOUBT
    assert lost[24, 18:22].all() and lost[24, 42:46].all()
    assert not lost[24, 22:42].any() and not lost[24, :18].any()
    # a triangulating sensor mixes nothing
    assert (weight_of(replace(sensor, principle="structured_light"), View(SL, step_image())) > 2e6 * DOUBT).all()


def test_a_window_cuts_the_maps_of_the_noise():
    noise = np.linspace(0.001, 0.002, 48 * 64).reshape(48, 64)
    sensor = Sensor(effects=(AxialNoise(c0=noise),))
    window = (slice(10, 30), slice(5, 40))
    part = of_window(sensor, STATED.shape, window)
    assert part.effects == (AxialNoise(c0=noise[window]),)
    assert of_window(Sensor(effects=(AxialNoise(c0=0.001),)), STATED.shape, window).effects == (AxialNoise(c0=0.001),)
