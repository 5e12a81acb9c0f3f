"""What was taken, before any format: true depth, camera, colour, stamps and poses; and as a file for other programs."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lens:
    """A camera as OpenCV counts: (0, 0) is the centre of the upper left pixel; `bend` is k1, k2, p1, p2, k3 to k6."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    bend: tuple[float, ...] = (0.0,) * 8

    @property
    def four(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy [px]."""
        return self.fx, self.fy, self.cx, self.cy

    @property
    def matrix(self) -> Array:
        """(3, 3)."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    def rays(self) -> Array:
        """(h, w, 2) x/z and y/z of every pixel; a bent lens is undone by Newton's method on its formula."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        seen = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy], axis=-1)
        if not any(self.bend):
            return seen
        rays = seen.copy()
        for _ in range(60):
            here, d = self.bent(rays), 1e-6
            right, down = np.array([d, 0]), np.array([0, d])
            dx = (self.bent(rays + right) - here) / d
            dy = (self.bent(rays + down) - here) / d
            step = np.linalg.solve(np.stack([dx, dy], axis=-1), (seen - here)[..., None])[..., 0]
            rays = rays + np.clip(step, -0.2, 0.2)
        return rays

    def bent(self, rays: Array) -> Array:
        """x/z and y/z (..., 2) as the lens shows them: OpenCV's formula with eight values."""
        k1, k2, p1, p2, k3, k4, k5, k6 = self.bend
        x, y = rays[..., 0], rays[..., 1]
        q = x * x + y * y
        radial = (1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6)))
        across = x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x)
        down = y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y
        return np.stack([across, down], axis=-1)

    def project(self, points: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) in front of it."""
        where = self.bent(points[..., :2] / points[..., 2:])
        return where * [self.fx, self.fy] + [self.cx, self.cy]


@dataclass(frozen=True)
class Take:
    """One recording to write.

    Attributes:
        lens: of depth; `color_lens` of colour, and T_color_depth (4, 4) from the one to the other.
        depth: (n, h, w) planar [m], 0 where there is none; long takes hold a few, which come again and again.
        color: (n, H, W, 3) uint8 RGB in the pixels of `color_lens`, or None.
        stamps: (n,) [s].
        poses: (n, 4, 4) camera to world, x right, y down, z forward; None where the camera stands still.
        unit: of counts [m], where a format is free to choose.
    """

    lens: Lens
    depth: NDArray[np.floating]
    stamps: NDArray[np.floating]
    color: NDArray[np.uint8] | None = None
    color_lens: Lens | None = None
    T_color_depth: Array = field(default_factory=lambda: np.eye(4))
    poses: Array | None = None
    unit: float = 0.001

    def counts(self, unit: float | None = None) -> NDArray[np.uint16]:
        """(n, h, w) rounded to counts."""
        return np.rint(self.depth / (unit or self.unit)).astype(np.uint16)


def save(take: Take, path: Path) -> Path:
    """As .npz, for writers that live in environments of their own (numpy alone reads it)."""
    held = {"depth": take.counts(), "unit": take.unit, "stamps": take.stamps, "lens": take.lens.four}
    if take.color is not None and take.color_lens is not None:
        held |= {"color": take.color, "color_lens": take.color_lens.four, "T": take.T_color_depth}
        held |= {"color_bend": take.color_lens.bend}
    if take.poses is not None:
        held |= {"poses": take.poses}
    np.savez(path, **held)  # type: ignore[arg-type]
    return path
