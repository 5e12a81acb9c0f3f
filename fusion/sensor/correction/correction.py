"""Correction: the inverse of a sensor model, from what a recording holds to the depth of the true camera."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.correction.estimate import edges_of, normals_of, reflectance_of
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View, incidence_of, stretch

USUAL = 0.5  # reflectance: guess; from 0.25 to 1 an error that goes with 1 / IR is halved or more
STEEPEST = np.radians(84.0)  # beyond, the normals of a noisy depth image say nothing


def corrected_image(
    sensor: Sensor, depth: Image, stated: Camera, ir: NDArray | None = None, moment: Moment | None = None
) -> Image:
    """The depth (h, w) [m] along the rays of `true_camera`, NaN where missing or where the model has no solution.

    Args:
        stated: camera, as stated with the image.
        ir: (h, w) amplitude [count]; without, surfaces are taken to be of usual brightness where the model knows its
            lamp, else effects that depend on it change nothing.
        moment: time, temperature and the like, as far as known.

    Raises:
        SensorError: the model holds maps of another image size.
    """
    view = view_of(sensor, depth, stated, ir, moment)
    found = np.asarray(sensor.correct(depth, view), np.float32)
    true = true_camera(sensor, stated)
    if true != stated and view.time_of_flight:  # the range was right, and was made a depth along the stated rays
        found = found * (stretch(stated) / stretch(true))
    return found


def true_camera(sensor: Sensor, stated: Camera) -> Camera:
    """The camera that took the pictures, by the model's errors of the camera that are known for this unit."""
    for effect in camera_effects(sensor):
        stated = effect.true_camera(stated)
    return stated


def camera_effects(sensor: Sensor) -> tuple[CameraEffect, ...]:
    """The errors of the camera that are undone by the true one."""
    return tuple(e for e in sensor.effects if isinstance(e, CameraEffect) and not sensor.usual(e))


def view_of(
    sensor: Sensor, depth: Image, camera: Camera, ir: NDArray | None = None, moment: Moment | None = None
) -> View:
    """What is known of a measured image, no more than the effects ask for that are undone."""
    view = View(camera, depth, ir=ir, baseline=sensor.baseline, moment=moment or Moment(), principle=sensor.principle)
    asked = {v for e in sensor.effects if e.changes("bias") and not sensor.why_not_corrected(e) for v in e.variables}
    with np.errstate(all="ignore"):
        if asked & {"incidence", "reflectance"}:
            normals = normals_of(depth, camera)
            view = replace(view, normals=normals, incidence=incidence_of(normals, camera))
        if "amplitude" in asked and ir is None:
            view = replace(view, ir=usual_light(sensor, view))
        if "reflectance" in asked and ir is not None:
            view = replace(view, reflectance=reflectance_of(view))
        if "edge" in asked:
            view = replace(view, edges=edges_of(view))
    return view


def usual_light(sensor: Sensor, view: View) -> Image | None:
    """Amplitude (h, w) [count] by distance and incidence; None where the model does not know its lamp.

    Where a neighbour is missing, and with it the incidence, the surface counts as frontal; 0 where there is no depth.
    """
    lamp = sensor.effect("illumination_vignetting")
    if view.depth is None or not isinstance(lamp, IlluminationVignetting) or not np.any(lamp.ir_at_1m):
        return None
    with np.errstate(all="ignore"):
        incidence = view.incidence
        if incidence is None:
            incidence = incidence_of(normals_of(view.depth, view.camera), view.camera)
        incidence = np.minimum(np.nan_to_num(incidence), STEEPEST)
        usual = np.full(view.depth.shape, USUAL, np.float32)
        light = sensor.amplitude(replace(view, incidence=incidence, reflectance=usual))
        return None if light is None else np.nan_to_num(light)
