"""Pose jitter: the camera shakes from frame to frame, and every pixel of a frame shares the shake."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import moved_rigidly, towards
from fusion.sensor.parameter import parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class PoseJitter(Effect):
    """Each frame is seen after a random turn about the camera and a random shift, normal in each coordinate.

    A field of rank six over the image: `noise` is its spread at each pixel, not independent between pixels. 0 where
    the normals are not known.
    """

    name: ClassVar[str] = "pose_jitter"
    key: ClassVar[str] = "M3"
    formula: ClassVar[str] = (
        "sigma_z = sqrt(sigma_m^2 + sigma_rad^2 |n x P|^2) / |n . ray|, P the point seen, n its normal"
    )
    variables: ClassVar[tuple[str, ...]] = ("depth", "incidence")

    sigma_m: float = parameter(
        "m", (0, 0.1), "shift along each axis", "first principles; size: guess", typical=0.001, kind="scalar"
    )
    sigma_rad: float = parameter(
        "rad", (0, 0.1), "turn about each axis", "first principles; size: guess", typical=0.002, kind="scalar"
    )

    def noise(self, depth: Image, view: View) -> Image:
        if view.normals is None or not (self.sigma_m or self.sigma_rad):
            return np.zeros((), depth.dtype)
        # n . (w x P + t) = w . (P x n) + t . n, with |ray x n|^2 = |ray|^2 - (n . ray)^2
        along = towards(view)
        across = np.sqrt(np.maximum(view.stretch**2 - along**2, 0.0))
        sigma = np.hypot(self.sigma_m, self.sigma_rad * depth * across) / np.abs(along)
        return np.where(np.isfinite(sigma), sigma, 0.0).astype(depth.dtype)

    def window(self, view: View) -> float:
        return 4.0 * max(view.camera.shape)  # all pixels of a frame shake together

    def sampled(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        return depth + moved_rigidly(depth, self.shake(rng), view)

    def shake(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """(6,) the motion of everything that is seen in one frame, as `RigEffect.motion`: a renderer's draw."""
        return rng.standard_normal(6) * np.repeat([self.sigma_rad, self.sigma_m], 3)
