"""Correction: the inverse of a sensor model, from what a recording holds to the depth of the true camera."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.correction.estimate import edges_of, normals_of, reflectance_of
from fusion.sensor.correction.usual_light import usual_light
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View, incidence_of, stretch
from fusion.sensor.weights.rating import sigma_of, weight_of


@dataclass(frozen=True)
class CorrectedDepth:
    """A depth image without what the sensor did to it, as far as that can be undone.

    Attributes:
        depth: (h, w) [m], NaN where missing or where the model has no solution.
        sigma: (h, w) standard deviation [m]; NaN where the depth is missing.
        weight: (h, w) [1/m^2]; 0 where the depth is missing or of no use.
        camera: the true camera, to which the depth belongs.
    """

    depth: Image
    sigma: Image
    weight: Image
    camera: Camera


def corrected(
    sensor: Sensor, depth: Image, camera: Camera, ir: NDArray | None = None, moment: Moment | None = None
) -> CorrectedDepth:
    """Undo a sensor's errors of a measured depth image (h, w) [m], and say how good each pixel is.

    Args:
        camera: as stated with the image.
        ir: (h, w) amplitude [count]; without, surfaces are taken to be of usual brightness where the model knows its
            lamp, else effects that depend on it change nothing.
        moment: time, temperature and the like, as far as known.

    Raises:
        SensorError: the model holds maps of another image size.
    """
    found = corrected_image(sensor, depth, camera, ir, moment)
    true = true_camera(sensor, camera)
    view = View(true, found, incidence_of(normals_of(found, true), true), ir=ir, moment=moment or Moment())
    sigma = sigma_of(sensor, view)
    return CorrectedDepth(found, sigma, weight_of(sensor, view, sigma), true)


def corrected_image(
    sensor: Sensor, depth: Image, stated: Camera, ir: NDArray | None = None, moment: Moment | None = None
) -> Image:
    """The depth (h, w) [m] along the rays of `true_camera`; arguments as in `corrected`."""
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
