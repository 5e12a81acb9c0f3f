"""Brightness from walls with one infrared image each: the lamp they tell serves recordings that have none."""

from dataclasses import replace

import numpy as np

from fusion.calibration.depth.calibration import calibrate_walls
from fusion.calibration.depth.known import Start
from fusion.calibration.depth.walls.lamp import WHITE, with_lamp
from fusion.calibration.depth.walls.plane import WallPlane
from fusion.calibration.depth.walls.wall import Means, Wall, wall_of
from fusion.geometry.camera import Camera
from fusion.sensor.correction.correction import USUAL, corrected_image
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, incidence_of

CAMERA = Camera(96, 72, 70.0, 70.0, 47.5, 35.5, principle="itof", sensor="T")
LAMP = IlluminationVignetting(exponent=2.0, ir_at_1m=10_000.0)
TRUE = Sensor(
    principle="itof", effects=(LAMP, DepthOffset(0.004), AmplitudeError(coefficient=0.004, ir_reference=1000.0))
)
NOISE, LASER = 2e-4, 2e-4  # [m]
IR_NOISE = 0.02  # of one image


def view_of(plane: WallPlane, reflectance: float) -> View:
    """What the sensor sees of a plane, its amplitude included."""
    depth = plane.depth(CAMERA)
    normal = -np.array([plane.a, plane.b, 1.0]) / np.sqrt(plane.a**2 + plane.b**2 + 1)
    incidence = incidence_of(np.broadcast_to(normal, (*CAMERA.shape, 3)), CAMERA)
    view = View(CAMERA, depth, incidence, reflectance=np.full(CAMERA.shape, reflectance))
    return replace(view, ir=TRUE.amplitude(view))


def walls() -> list[Wall]:
    """White walls from 0.7 to 2.3 m."""
    rng, known, found = np.random.default_rng(0), Sensor(principle="itof"), []
    for z in np.linspace(0.7, 2.3, 9):
        plane = WallPlane(float(z), *rng.normal(0, 0.03, 2))
        view = view_of(plane, WHITE)
        measured = TRUE.predict(view.depth, view) + NOISE * rng.standard_normal(CAMERA.shape)
        ir = view.ir * (1 + IR_NOISE * rng.standard_normal(CAMERA.shape))
        means = Means(100, measured, np.full(CAMERA.shape, 10 * NOISE), ir)
        found.append(wall_of(means, CAMERA, known, (f"{z:.1f} m", z + rng.normal(0, LASER), LASER)))
    return found


def test_walls_tell_the_lamp():
    found = with_lamp(Sensor(principle="itof"), walls(), CAMERA).effect("illumination_vignetting")
    assert isinstance(found, IlluminationVignetting)
    # the measured distances err by 4 to 40 mm where the light is least, and count squared: 1 % at most of 1.5 m
    np.testing.assert_allclose(found.ir_at_1m, LAMP.ir_at_1m, rtol=0.02)
    np.testing.assert_allclose(found.exponent, LAMP.exponent, atol=0.1)


def test_a_recording_without_infrared_is_corrected_as_of_usual_brightness():
    known = Sensor(principle="itof")
    found = calibrate_walls(walls(), Start(CAMERA, known, known, None, "", "", ()), surface=False)
    assert "amplitude" in found.best.law.keys
    view = view_of(WallPlane(1.2, 0.5, 0.2), USUAL)
    measured = TRUE.predict(view.depth, view)
    corrected = corrected_image(found.sensor, measured, CAMERA)
    inner = np.s_[1:-1, 1:-1]  # where neighbours tell the incidence
    error = (corrected - view.depth)[inner]
    brightness = (measured - view.depth - 0.004)[inner]
    # the lamp is found to 1 %; light is reckoned from the measured depth, and the incidence from its differences
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.sqrt(np.mean(brightness**2))


def test_no_lamp_no_guess():
    sensor = Sensor(principle="itof", effects=(AmplitudeError(coefficient=0.004),))
    depth = np.full(CAMERA.shape, 1.5)
    np.testing.assert_allclose(corrected_image(sensor, depth, CAMERA), depth)
