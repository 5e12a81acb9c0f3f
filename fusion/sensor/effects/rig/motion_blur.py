"""Motion blur: while the shutter is open an edge moves over some pixels, which then see both sides in turn."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.edges.mixing import mixed
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class MotionBlur(Effect):
    """An edge moves by s in the exposure; a pixel at distance d from it sees the other side for 1/2 - d/s of the time.

    The edge is where it stands in the middle of the exposure and belongs to the surface in front: its velocity counts.
    Unchanged where the edges or the velocity are not known. The mean over the exposure of a surface that moves
    steadily is its middle, so only edges change.
    """

    name: ClassVar[str] = "motion_blur"
    key: ClassVar[str] = "M1"
    formula: ClassVar[str] = (
        "share across the edge = max(0, 1/2 - d / s), d = distance to the edge, s = shutter times its speed [px/s]"
    )
    variables: ClassVar[tuple[str, ...]] = ("velocity", "edge", "depth")
    not_corrected: ClassVar[str] = "one depth image does not tell how fast an edge moves"

    shutter: float = parameter(
        "s", (0, 0.5), "how long the shutter is open", "first principles; size: guess", typical=0.02, kind="scalar"
    )

    def bias(self, depth: Image, view: View) -> Image:
        return mixed(self._share(depth, view), depth, view)[0]

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        return amplitude * mixed(self._share(depth, view), depth, view)[1]

    def _share(self, depth: Image, view: View) -> Image:
        """Share (h, w) of the exposure in which a pixel sees what lies across its nearest edge."""
        share = np.zeros_like(depth)
        if view.edges is None or view.velocity is None or not self.shutter:
            return share
        where = np.flatnonzero(np.isfinite(view.edges.distance) & (view.edges.jump != 0) & np.isfinite(depth))
        smear = self.shutter * np.abs(speed_of_edges(where, depth, view))
        with np.errstate(divide="ignore", invalid="ignore"):
            part = 0.5 - view.edges.distance.flat[where] / smear  # 0/0 where nothing moves
        share.flat[where] = np.clip(np.nan_to_num(part), 0.0, 0.5)
        return share


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
