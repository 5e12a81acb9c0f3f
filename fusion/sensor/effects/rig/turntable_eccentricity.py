"""Turntable eccentricity: the table turns about another axis than stated, so objects are shifted as they turn."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effects.rig.table import table_frame
from fusion.sensor.laws.moving import RigEffect
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameter


@dataclass(frozen=True)
class TurntableEccentricity(RigEffect):
    """The true axis is parallel to the stated one, `offset` away in the plate's direction `phase`.

    With E the vector from the stated to the true axis and R the turn by the table angle, an object that is where it
    should be at angle 0 stands E - R E too far: offset * (1 - cos) along E, -offset * sin across it. Phase 0 is
    towards the camera (`table_frame`), right-handed about the axis.
    """

    name: ClassVar[str] = "turntable_eccentricity"
    key: ClassVar[str] = "R1"
    formula: ClassVar[str] = "shift = E - R(table angle) E, E = offset at the angle phase from the camera's direction"
    variables: ClassVar[tuple[str, ...]] = ("table_angle", "incidence")

    offset: float = parameter(
        "m",
        (0, 0.05),
        "distance of the true axis from the stated one",
        "first principles; 0.05 to 0.5 mm is from memory",
        typical=0.0005,
        kind="scalar",
    )
    phase: float = parameter(
        "rad",
        (-2 * np.pi, 2 * np.pi),
        "where the true axis lies, from the direction of the camera",
        "convention",
        typical=0.8,
        kind="scalar",
    )

    def motion(self, moment: Moment) -> NDArray[np.float64] | None:
        frame = table_frame(moment)
        if frame is None or not self.offset:
            return None
        turned = self.phase + moment.table_angle
        shift = np.array([np.cos(self.phase) - np.cos(turned), np.sin(self.phase) - np.sin(turned), 0.0])
        return np.concatenate([np.zeros(3), self.offset * shift @ frame])
