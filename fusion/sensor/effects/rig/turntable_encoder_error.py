"""Turntable encoder error: the table has not turned as far as its encoder says, by an error that repeats each turn."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effects.rig.table import table_frame, turned_about
from fusion.sensor.forms import Atom, Form
from fusion.sensor.laws.moving import RigEffect
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import Value, parameter

HARMONICS = 2  # of a turn that are looked for
SMALL = 2.5e-4  # [rad] small enough to be linear


@dataclass(frozen=True)
class TurntableEncoderError(RigEffect):
    """At the stated angle the object has turned further by the sum of amplitude_k sin(k angle + phase_k), k = 1, 2, ...

    Right-handed about the axis, as the angle. One phase for several amplitudes is that of all.
    """

    name: ClassVar[str] = "turntable_encoder_error"
    key: ClassVar[str] = "R1"
    formula: ClassVar[str] = (
        "true angle = angle + amplitude_1 sin(angle + phase_1) + amplitude_2 sin(2 angle + ...) ..."
    )
    variables: ClassVar[tuple[str, ...]] = ("table_angle", "incidence")

    amplitude: Value = parameter(
        "rad",
        (-0.2, 0.2),
        "error of the angle, one value per harmonic of a turn",
        "first principles; 0.05 to 0.5 deg is from memory",
        typical=0.005,
        kind="list",
    )
    phase: Value = parameter(
        "rad",
        (-2 * np.pi, 2 * np.pi),
        "of the error at angle 0, one value per harmonic",
        "convention",
        typical=0.8,
        kind="list",
    )

    def motion(self, moment: Moment) -> NDArray[np.float64] | None:
        frame = table_frame(moment)
        further = self.further(moment.table_angle)
        if frame is None or moment.axis_point is None or not further:
            return None
        return turned_about(moment.axis_point, further * frame[2])

    def further(self, angle: float) -> float:
        """How much further than a stated angle [rad] the table has turned [rad]."""
        amplitude = np.atleast_1d(self.amplitude)
        harmonic = np.arange(1, len(amplitude) + 1)
        return float((amplitude * np.sin(harmonic * angle + self.phase)).sum())

    @classmethod
    def own_forms(cls, shape: tuple[int, int]) -> list[Form]:
        """Once and twice a turn together: a place in the lists is a harmonic, so waves are not added one by one."""
        atoms = tuple(
            {"amplitude": [0.0] * order + [SMALL], "phase": [0.0] * order + [phase]}
            for order in range(HARMONICS)
            for phase in (0.0, np.pi / 2)
        )
        return [Form(cls, atoms=atoms, join=_joined)]


def _joined(atoms: Sequence[Atom], weights: Sequence[float]) -> Atom:
    """A sine and a cosine of each order are one wave with a phase."""
    along, across = np.asarray(weights, float).reshape(HARMONICS, 2).T
    return {"amplitude": SMALL * np.hypot(along, across), "phase": np.arctan2(across, along)}
