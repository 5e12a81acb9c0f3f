"""Focal length error: the stated focal length is too long, so every ray is stated too near the axis."""

from dataclasses import dataclass, replace
from typing import ClassVar

from fusion.geometry.camera import Camera
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.parameter import parameter


@dataclass(frozen=True)
class FocalLength(CameraEffect):
    """The stated fx and fy are (1 + relative) times the true ones.

    A frontal wall keeps its depth where the sensor triangulates. Where it measures along the ray, the wall becomes a
    bowl: z_measured / z - 1 = relative rho^2 / (1 + rho^2), with rho the tangent of the angle to the axis.
    """

    name: ClassVar[str] = "focal_length"
    key: ClassVar[str] = "G1"
    formula: ClassVar[str] = (
        "z_measured = n . P / (n . true ray), itof: times |true ray| / |stated ray|; "
        "true ray = (x (1 + relative), y (1 + relative), 1) for the stated ray (x, y, 1)"
    )
    variables: ClassVar[tuple[str, ...]] = ("radius", "depth", "incidence")

    relative: float = parameter(
        "1",
        (-0.3, 0.3),
        "stated over true focal length, minus 1",
        "first principles; 0.002 to 0.01 is from memory",
        typical=0.01,
        kind="scalar",
    )

    def true_camera(self, stated: Camera) -> Camera:
        return replace(stated, fx=stated.fx / (1 + self.relative), fy=stated.fy / (1 + self.relative))
