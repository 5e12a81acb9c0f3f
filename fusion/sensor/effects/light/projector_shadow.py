"""Projector shadow: what the camera sees but the projector does not has no pattern, hence no depth."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class ProjectorShadow(Effect):
    """No value where the projector's ray ends on a nearer surface: `view.lit`, or found along the rows of the depth.

    The shadow lies on the side away from the projector and is fx b (1 / z_near - 1 / z_far) wide.
    """

    name: ClassVar[str] = "projector_shadow"
    key: ClassVar[str] = "S1"
    formula: ClassVar[str] = "width = fx b (1 / z_near - 1 / z_far) [px], away from the projector"
    variables: ClassVar[tuple[str, ...]] = ("edge", "disparity")
    principles: ClassVar[tuple[str, ...]] = ("structured_light", "active_stereo")

    baseline: Value = parameter(
        "m",
        (-1, 1),
        "place of the projector on the camera's x axis, negative to the left",
        "geometry; about 0.075 m: Pagliari 2014",
        typical=-0.075,
    )

    def dropout(self, depth: Image, view: View) -> Image:
        baseline = float(np.mean(self.baseline))
        if not baseline:
            return np.zeros((), depth.dtype)
        if view.lit is not None:
            return 1.0 - np.nan_to_num(np.asarray(view.lit, depth.dtype), nan=1.0)
        return shadowed(depth, baseline, view).astype(depth.dtype)


def shadowed(depth: Image, baseline: float, view: View) -> NDArray[np.bool_]:
    """(h, w) True where the projector at `baseline` [m] does not reach the surface of a depth image (h, w) [m]."""
    column = np.asarray(view.camera.rays()[..., 0] * view.camera.fx, depth.dtype)
    if baseline < 0:
        return _right_of_near(depth, column, view.camera.fx * -baseline)
    return _right_of_near(depth[:, ::-1], -column[:, ::-1], view.camera.fx * baseline)[:, ::-1]


def _right_of_near(depth: Image, column: Image, focal_baseline: float) -> NDArray[np.bool_]:
    """The same for a projector on the left: shadows fall to the right.

    A point is seen by the projector in the column t = u + fx b / z. What hides it has the same t and is nearer, so it
    lies to its left: only where a t further left has reached so far (half a pixel is its own width) can be shadow.
    There the nearest surface of each projector column decides, so that light passes on both sides of a thin rod.
    """
    width = depth.shape[1]
    disparity = np.minimum(focal_baseline / np.where(depth > 0, depth, np.inf), 4.0 * width).astype(depth.dtype)
    t = column + disparity
    reached = np.maximum.accumulate(np.where(disparity > 0, t, -np.inf), axis=1)
    candidate = np.zeros(depth.shape, bool)
    candidate[:, 1:] = (reached[:, :-1] + 0.5 > t[:, 1:]) & (disparity[:, 1:] > 0)
    rows = np.flatnonzero(candidate.any(axis=1))
    if not len(rows):
        return candidate
    t, disparity = t[rows] - float(np.min(column)), disparity[rows]
    place = np.floor(t).astype(np.intp)
    seen = np.zeros((2, len(rows), int(place.max()) + 3), depth.dtype)
    index = np.arange(len(rows))[:, None]
    # written from right to left, the last of equal columns stays: the leftmost, which is the nearest
    for splat in (0, 1):  # a point between two columns fills both
        seen[splat, index, place[:, ::-1] + splat] = disparity[:, ::-1]
    nearest = np.maximum(seen[0], seen[1])
    # one pixel nearer is another surface, and not a slope
    candidate[rows] &= nearest[index, np.rint(t).astype(np.intp)] > disparity + 1.0
    return candidate
