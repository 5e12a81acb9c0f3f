"""Lens distortion: the true lens bends rays differently from the stated one."""

from dataclasses import dataclass, replace
from typing import ClassVar

from fusion.geometry.camera import Camera
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.parameter import parameter

_SOURCE = "Brown-Conrady as in OpenCV; size from memory"


@dataclass(frozen=True)
class LensDistortion(CameraEffect):
    """The true camera's k1, k2, k3, p1, p2 are the stated ones plus these; for an undistorted camera they are its own.

    With (x, y) the ray and r^2 = x^2 + y^2, the pixel is at x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y +
    p2 (r^2 + 2 x^2), and at y likewise with p1 and p2 exchanged.
    """

    name: ClassVar[str] = "lens_distortion"
    key: ClassVar[str] = "G2, G3"
    formula: ClassVar[str] = (
        "z_measured = n . P / (n . true ray), itof: times |true ray| / |stated ray|; "
        "true ray: undistorted with the stated values plus (k1, k2, k3, p1, p2)"
    )
    variables: ClassVar[tuple[str, ...]] = ("radius", "u", "v", "depth", "incidence")

    k1: float = parameter("1", (-0.5, 0.5), "true minus stated, of r^2", _SOURCE, typical=0.05, kind="scalar")
    k2: float = parameter("1", (-0.5, 0.5), "true minus stated, of r^4", _SOURCE, typical=-0.05, kind="scalar")
    k3: float = parameter("1", (-0.5, 0.5), "true minus stated, of r^6", _SOURCE, typical=0.02, kind="scalar")
    p1: float = parameter("1", (-0.05, 0.05), "true minus stated, of 2 x y", _SOURCE, typical=0.001, kind="scalar")
    p2: float = parameter(
        "1", (-0.05, 0.05), "true minus stated, of r^2 + 2 x^2", _SOURCE, typical=0.001, kind="scalar"
    )

    def true_camera(self, stated: Camera) -> Camera:
        more = (self.k1, self.k2, self.p1, self.p2, self.k3)  # OpenCV's order
        k = stated.distortion
        return replace(stated, distortion=(*(a + b for a, b in zip(k[:5], more, strict=True)), *k[5:]))
