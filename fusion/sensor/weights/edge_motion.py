"""How fast depth edges move over the image."""

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image, View


def speed_of_edges(where: NDArray[np.intp], depth: Image, view: View) -> NDArray[np.floating]:
    """Speed (n,) [px/s] at which the edges nearest to some pixels move across themselves, positive away from them.

    An edge belongs to the surface in front, and moves with it. 0 where the velocity is not known or nothing is near.

    Args:
        where: (n,) flat indices of the pixels.
        depth: (h, w) [m].
        view: with edges and velocity.
    """
    assert view.edges is not None and view.velocity is not None
    camera = view.camera
    v, u = np.divmod(where, camera.width)
    jump, direction = (np.nan_to_num(image.flat[where]) for image in (view.edges.jump, view.edges.direction))
    distance = np.nan_to_num(view.edges.distance.flat[where], posinf=0.0)
    right, down = np.cos(direction), np.sin(direction)
    # the surface in front: the pixel's own, or that of the first pixel across the edge
    reach = np.where(jump < 0, distance + 1.0, 0.0)
    row = np.clip(np.rint(v + reach * down), 0, camera.height - 1).astype(np.intp)
    column = np.clip(np.rint(u + reach * right), 0, camera.width - 1).astype(np.intp)
    velocity_x, velocity_y, velocity_z = view.velocity[row, column].T
    ray_x, ray_y = camera.rays()[v, u].T + distance * (right / camera.fx, down / camera.fy)  # of the edge
    # d(X / Z) / dt = (velocity_x - ray_x velocity_z) / Z
    speed_u = camera.fx * (velocity_x - ray_x * velocity_z)
    speed_v = camera.fy * (velocity_y - ray_y * velocity_z)
    with np.errstate(all="ignore"):
        speed = (speed_u * right + speed_v * down) / (depth.flat[where] + np.minimum(jump, 0))
    return np.where(np.isfinite(speed), speed, 0.0).astype(depth.dtype)
