"""Principal point error: the stated optical axis goes through another pixel than the true one."""

from dataclasses import dataclass, replace
from typing import ClassVar

from fusion.geometry.camera import Camera
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.parameter import parameter


@dataclass(frozen=True)
class PrincipalPoint(CameraEffect):
    """The stated principal point is the true one plus (cx, cy): nearly as if the camera were turned."""

    name: ClassVar[str] = "principal_point"
    key: ClassVar[str] = "G1"
    formula: ClassVar[str] = (
        "z_measured = n . P / (n . true ray), itof: times |true ray| / |stated ray|; "
        "true ray = stated ray + (cx / fx, cy / fy, 0)"
    )
    variables: ClassVar[tuple[str, ...]] = ("u", "v", "depth", "incidence")

    cx: float = parameter(
        "px",
        (-100, 100),
        "stated minus true column",
        "first principles; 1 to 5 px is from memory",
        typical=3.0,
        kind="scalar",
    )
    cy: float = parameter(
        "px",
        (-100, 100),
        "stated minus true row",
        "first principles; 1 to 5 px is from memory",
        typical=-2.0,
        kind="scalar",
    )

    def true_camera(self, stated: Camera) -> Camera:
        return replace(stated, cx=stated.cx - self.cx, cy=stated.cy - self.cy)
