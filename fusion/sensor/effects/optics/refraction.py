"""Refraction: a pane of glass before the sensor shifts every ray, and light takes longer in it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import moved
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Refraction(Effect):
    """A plane pane across the optical axis, before camera and projector or lamp; its distance does not matter.

    Let rho be the tangent of the ray's angle in the air and rho' in the glass, rho' = rho / q by Snell's law with
    q = sqrt(index^2 (1 + rho^2) - rho^2). Behind the pane the ray goes on parallel to itself, nearer to the axis by
    s = thickness (rho - rho'): a tilted surface is seen elsewhere (`across`; not where the normals are unknown).
    Time of flight: thickness of glass at index / cos' replaces air at 1 / cos, so that the depth grows by
    thickness (index cos / cos' - 1). Triangulation: a point's ray is at the tangent rho with
    rho z - s = (its distance from the axis), and the depth is baseline / (difference of tangents), to first order
    in the baseline along x: shorter by thickness (1 - d(rho')/d(rho)) along x, by thickness (1 - rho'/rho) across.
    """

    name: ClassVar[str] = "refraction"
    key: ClassVar[str] = "P1"
    formula: ClassVar[str] = (
        "itof: z + thickness (index cos / cos' - 1); else: z - thickness (1 - 1 / index) on the axis"
    )
    variables: ClassVar[tuple[str, ...]] = ("radius", "incidence")

    thickness: Value = parameter("m", (0, 0.1), "of the pane", "Snell's law; window glass: guess", typical=0.004)
    index: Value = parameter("1", (1.0, 4.0), "of refraction", "Snell's law; glass 1.5", neutral=1.5)

    def bias(self, depth: Image, view: View) -> Image:
        if not np.any(self.thickness):
            return np.zeros((), depth.dtype)
        rays = view.camera.rays()
        x2, y2 = rays[..., 0] ** 2, rays[..., 1] ** 2
        rho2 = x2 + y2
        thickness, n2 = (np.asarray(a, depth.dtype) for a in (self.thickness, np.square(self.index)))
        q = np.sqrt(n2 * (1 + rho2) - rho2)
        if view.time_of_flight:
            # cos' = q / (index sqrt(1 + rho^2)) and cos = 1 / sqrt(1 + rho^2)
            longer = thickness * (n2 / q - 1)
        else:
            # d(rho')/d(rho) = index^2 / q^3 along the radius, rho'/rho = 1 / q across it; x^2 / rho^2 of the first
            radial = x2 / np.maximum(rho2, 1e-12)
            longer = -thickness * (1 - radial * n2 / q**3 - (1 - radial) / q)
        return (longer + self._across(depth, thickness * (1 - 1 / q), view)).astype(depth.dtype)

    def _across(self, depth: Image, shift: Image, view: View) -> Image:
        """Change [m] because a ray of slope rho lies `shift` * rho nearer to the axis: as if the surface moved out."""
        rays = view.camera.rays()
        out = np.dstack([rays, np.zeros(depth.shape, rays.dtype)])
        return moved(depth, out, view) * shift
