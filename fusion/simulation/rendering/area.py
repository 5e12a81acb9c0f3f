"""Area: a pixel sees a part of the scene, not a point; with few pixels that is a large one."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.view import Image, View, stretch
from fusion.simulation.rendering.casting import CastBodies, directions

FINE_PX = 64  # across an image: with fewer pixels than these each is made of several rays
ALONE_PX = 1.0  # from a depth edge: nearer, a pixel may see both sides, of which effects of edges tell


def over_area(view: View, stage: CastBodies) -> View:
    """Depth as the mean over what each pixel sees, in the units in which the sensor measures, where an image has few.

    A time-of-flight sensor weighs lengths of rays by their light, which falls with the square of the distance and with
    the slant; others take the mean of what is in proportion to the disparity. A pixel that an edge passes keeps what
    is in its middle.
    """
    camera, depth = view.camera, view.depth
    times = -(-FINE_PX // camera.width)
    if times < 2 or depth is None:
        return view
    fine = camera.resized(camera.width * times, camera.height * times)
    rays = directions(fine)
    hits = stage.first(rays)
    z = hits.t.reshape(camera.height, times, camera.width, times)
    with np.errstate(all="ignore"):
        if camera.principle == Principle.TIME_OF_FLIGHT:
            along = stretch(fine).reshape(z.shape)
            length, facing = z * along, np.abs((hits.normals * rays).sum(axis=1)).reshape(z.shape) / along
            light = facing / length**2
            mean = (light * length).sum(axis=(1, 3)) / light.sum(axis=(1, 3)) / stretch(camera)
        else:
            mean = 1.0 / (1.0 / z).mean(axis=(1, 3))
    whole = np.isfinite(z).all(axis=(1, 3))
    if view.edges is not None:
        whole &= view.edges.distance >= ALONE_PX
    bent = np.where(whole, _bent(z, times), np.inf).astype(np.float32)
    return replace(view, depth=np.where(whole, mean, depth).astype(depth.dtype), bent=bent)


def _bent(z: Image, times: int) -> Image:
    """(h, w) [m] by how much (rms) depths (h, times, w, times) of each pixel leave a plane."""
    with np.errstate(all="ignore"):
        inverse = 1.0 / z  # of a plane it is linear in the image
        across = (np.arange(times) - (times - 1) / 2.0) / times
        down = across[:, None, None]
        off = inverse - inverse.mean(axis=(1, 3), keepdims=True)
        slopes = [(off * at).mean(axis=(1, 3), keepdims=True) / (across**2).mean() for at in (across, down)]
        off = off - slopes[0] * across - slopes[1] * down
        return np.asarray(np.sqrt((off**2).mean(axis=(1, 3))) / inverse.mean(axis=(1, 3)) ** 2)
