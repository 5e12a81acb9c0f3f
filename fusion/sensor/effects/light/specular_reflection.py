"""Specular reflection: a glossy surface sends light back only where it faces the lamp, and away everywhere else."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class SpecularReflection(Effect):
    """A Phong lobe about the mirror direction; with the lamp at the camera that is twice the incidence off the ray.

    The light is shared: a lobe of peak `strength` over the diffuse light takes 2 strength / (exponent + 1) times the
    power of the diffuse part, which is missing outside the lobe (derived: their integrals over the half sphere are
    2 pi / (n + 1) and pi). The surface is taken as a mosaic of which that share is a mirror, and a mirror gives no
    value outside the lobe. Too much light inside it is the matter of `saturation`; ghosts are left out.
    """

    name: ClassVar[str] = "specular_reflection"
    key: ClassVar[str] = "I12"
    formula: ClassVar[str] = (
        "IR = IR_diffuse (1 - m) (1 + strength L / cos(incidence)), L = cos(2 incidence)^exponent, dropout = m (1 - L)"
    )
    variables: ClassVar[tuple[str, ...]] = ("incidence", "amplitude")

    strength: Value = parameter(
        "1", (0, 1000), "specular over diffuse light of a surface that faces the lamp", "Phong 1975", typical=1.0
    )
    exponent: Value = parameter(
        "1",
        (1, 10000),
        "how narrow the lobe is: 10 satin, 100 gloss, 1000 polish",
        "Phong 1975",
        neutral=30.0,
    )

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        if view.incidence is None or not np.any(self.strength):
            return amplitude
        # the lobe is 0 beyond 45 deg, where the cosine is still 0.7
        facing = np.maximum(np.cos(np.nan_to_num(view.incidence)), 0.7)
        return amplitude * (1.0 - self._mirror()) * (1.0 + self.strength * self._lobe(depth, view) / facing)

    def dropout(self, depth: Image, view: View) -> Image:
        if view.incidence is None or not np.any(self.strength):
            return np.zeros((), depth.dtype)
        return (self._mirror() * (1.0 - self._lobe(depth, view))).astype(depth.dtype)

    def _mirror(self) -> Value:
        """Share of the returned power that the lobe takes [1]."""
        taken = 2.0 * self.strength / (self.exponent + 1.0)
        return taken / (1.0 + taken)

    def _lobe(self, depth: Image, view: View) -> Image:
        """(h, w) the lobe in the direction of the camera, 1 for a surface that faces it."""
        twice = np.cos(2.0 * np.nan_to_num(np.asarray(view.incidence, depth.dtype)))
        return np.maximum(twice, 0.0) ** np.asarray(self.exponent, depth.dtype)
