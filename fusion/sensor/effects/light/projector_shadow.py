"""Projector shadow: what the camera sees but the projector does not has no pattern, hence no depth."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.compute.start import start
from fusion.geometry.camera import TRIANGULATING, Principle
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
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING

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

    def lit_from(self) -> float:
        return float(np.mean(self.baseline))


def shadowed(depth: Image, baseline: float, view: View) -> NDArray[np.bool_]:
    """(h, w) True where the projector at `baseline` [m] does not reach the surface of a depth image (h, w) [m].

    With a projector on the left shadows fall to the right. A point is seen by it in the column t = u + fx b / z. What
    hides it has the same t and is nearer, so it lies to its left: only where a t further left has reached so far can be
    shadow. There the nearest surface of each projector column decides, so that light passes on both sides of a thin
    rod. With a projector on the right all is mirrored.
    """
    from fusion.sensor.edges.shadow_kernels import cast_shadows  # starts Taichi

    start()
    width, focal = depth.shape[1], view.camera.fx
    with np.errstate(all="ignore"):
        disparity = np.float32(focal * abs(baseline)) / np.asarray(depth, np.float32)
        disparity = np.minimum(disparity, np.float32(4.0 * width))
        disparity[~(disparity > 0)] = 0
    column = view.camera.rays()[..., 0] * np.float32(focal if baseline < 0 else -focal)
    t = disparity + (column - column.min())
    shadow = np.empty(depth.shape, np.uint8)
    seen = np.empty((2, depth.shape[0], int(t.max()) + 3), np.float32)
    cast_shadows(t, disparity, baseline > 0, seen, shadow)
    return shadow.view(bool)
