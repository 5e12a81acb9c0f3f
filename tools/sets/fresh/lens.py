"""The true camera of a unit: pinhole with radial and decentring distortion (Brown 1966, in OpenCV's order)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lens:
    """Pixels; the centre of the top-left pixel is (0, 0). `bend` = k1, k2, p1, p2."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    bend: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    @property
    def fields(self) -> dict[str, Any]:
        """As in camera.json."""
        names = ("width", "height", "fx", "fy", "cx", "cy")
        return {name: getattr(self, name) for name in names} | {"distortion": [*self.bend, 0.0]}

    def _bent(self, x: Array, y: Array) -> tuple[Array, Array]:
        k1, k2, p1, p2 = self.bend
        q = x**2 + y**2
        grown = 1 + q * (k1 + q * k2)
        return x * grown + 2 * p1 * x * y + p2 * (q + 2 * x**2), y * grown + p1 * (q + 2 * y**2) + 2 * p2 * x * y

    def pixels(self, points: Array) -> Array:
        """(..., 2) where points (..., 3) in the camera's frame are seen."""
        x, y = self._bent(points[..., 0] / points[..., 2], points[..., 1] / points[..., 2])
        return np.stack([self.fx * x + self.cx, self.fy * y + self.cy], axis=-1)

    def rays(self, du: float = 0.0, dv: float = 0.0) -> Array:
        """(h, w, 3) directions with z = 1 of places `du, dv` px from the pixel centres."""
        u, v = np.meshgrid(np.arange(self.width) + du, np.arange(self.height) + dv)
        goal_x, goal_y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        x, y = goal_x, goal_y
        for _ in range(25):  # what it is bent by is small: each step shrinks the error several times
            bent_x, bent_y = self._bent(x, y)
            x, y = x + goal_x - bent_x, y + goal_y - bent_y
        return np.stack([x, y, np.ones(u.shape)], axis=-1)

    @property
    def covers(self) -> bool:
        """Whether every pixel has a ray: strong distortion folds the image back before its corners."""
        with np.errstate(over="ignore", invalid="ignore"):  # where there is none, the search runs away
            seen = self.pixels(self.rays())
        v, u = np.mgrid[: self.height, : self.width]
        return bool((np.abs(seen - np.stack([u, v], axis=-1)) < 0.01).all())

    def four(self) -> list[Array]:
        """Rays of four places of every pixel: left and right of its centre, above and below."""
        return [self.rays(du, dv) for dv in (-0.25, 0.25) for du in (-0.25, 0.25)]


def drawn(rng: np.random.Generator, nominal: Lens) -> Lens:
    """A unit's lens: focal length 1.5 % off (std), centre some pixels off, distorted; one that covers its image."""
    f = nominal.fx * (1 + 0.015 * np.clip(rng.standard_normal(), -2, 2))
    bend = (rng.uniform(-0.06, 0.06), rng.uniform(-0.08, 0.05), *rng.uniform(-5e-4, 5e-4, 2))
    cx, cy = nominal.cx + rng.uniform(-3, 3), nominal.cy + rng.uniform(-3, 3)
    ratio = 1 + 0.001 * rng.standard_normal()
    own = Lens(nominal.width, nominal.height, f, f * ratio, cx, cy, tuple(map(float, bend)))  # type: ignore[arg-type]
    return own if own.covers else drawn(rng, nominal)
