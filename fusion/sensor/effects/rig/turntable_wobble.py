"""Turntable wobble: the plate is not square to its axis, so its high side goes round and objects lean."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effects.rig.table import table_frame, turned_about
from fusion.sensor.laws.moving import RigEffect
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameter


@dataclass(frozen=True)
class TurntableWobble(RigEffect):
    """The plate's normal goes round its axis on a cone of half-angle `tilt`, about the stated point of the axis.

    Where the plate is nearest to the camera, at radius R, it rises by R tilt sin(table angle + phase); something at
    height h above the point shifts by h tilt in a direction that turns with the table. As seen from the table the
    lean never changes, so that it hides in the pose of a single object.
    """

    name: ClassVar[str] = "turntable_wobble"
    key: ClassVar[str] = "R1"
    formula: ClassVar[str] = "rise = R tilt sin(table angle + phase) at radius R towards the camera"
    variables: ClassVar[tuple[str, ...]] = ("table_angle", "incidence")

    tilt: float = parameter(
        "rad",
        (0, 0.2),
        "between the plate's normal and its axis",
        "first principles; 0.05 to 0.5 deg is from memory",
        typical=0.005,
        kind="scalar",
    )
    phase: float = parameter(
        "rad",
        (-2 * np.pi, 2 * np.pi),
        "of the rise of the side near the camera, at angle 0",
        "convention",
        typical=0.8,
        kind="scalar",
    )

    def motion(self, moment: Moment) -> NDArray[np.float64] | None:
        frame = table_frame(moment)
        if frame is None or moment.axis_point is None or not self.tilt:
            return None
        # a turn w lifts R e1 by axis . (w x R e1) = -R w . e2, with e1, e2 the frame's first two rows
        turned = moment.table_angle + self.phase
        lean = -self.tilt * (np.cos(turned) * frame[0] + np.sin(turned) * frame[1])
        return turned_about(moment.axis_point, lean)
