"""Rolling shutter: the rows are exposed one after the other, so what moves is sheared."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.effects.rig.timestamp_offset import TimestampOffset
from fusion.sensor.laws.surface import moved
from fusion.sensor.parameter import parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class RollingShutter(Effect):
    """Row v is exposed line_time * (v - middle row) after the time stamp, and sees what moves where it then stands.

    Positive: from the top row to the bottom row. Unchanged where the velocity or the normals are not known.
    """

    name: ClassVar[str] = "rolling_shutter"
    key: ClassVar[str] = "M2"
    formula: ClassVar[str] = "z_measured = z + t (n . velocity) / (n . ray), t = line_time (v - (height - 1) / 2)"
    variables: ClassVar[tuple[str, ...]] = ("velocity", "v", "incidence")
    not_corrected: ClassVar[str] = "one depth image does not tell how fast a surface moves"

    # 0.1 ms is 48 ms for 480 rows, longer than a frame at 30 Hz; the bounds take slower sensors
    line_time: float = parameter(
        "s",
        (-1e-3, 1e-3),
        "from the exposure of one row to that of the next",
        "first principles; 30 Hz over 480 rows is 7e-5 s",
        typical=7e-5,
        kind="scalar",
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.velocity is None:
            return np.zeros((), depth.dtype)
        late = self.line_time * (view.v - (view.camera.height - 1) / 2)  # (h, 1) [s]
        return moved(depth, view.velocity, view) * late.astype(depth.dtype)

    def other_zero(self, view: View) -> Effect | None:
        """A time stamp may be that of the first row, of the last, or of the frame before these."""
        return TimestampOffset(offset=abs(self.line_time) * view.camera.height)
