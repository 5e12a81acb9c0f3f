"""The light that stands still while an object turns: how bright a side is, by where it looks.

What a matt surface takes in of lamps far away is a quadratic polynomial of its normal, to 1 % (Ramamoorthi and
Hanrahan, An efficient representation for irradiance environment maps, SIGGRAPH 2001). Here its logarithm is one, so
that paint, exposure and light are a sum; and its numbers change along the object, as lamps are near.

What is the same in all views, such as a top that is brighter than a bottom, no view tells from paint: it stays.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.surface import RayMesh
from fusion.geometry.pose import Array

TERMS = 4 * 9  # 1 and the place, times 1 and what is linear and quadratic in the normal


@dataclass(frozen=True)
class Facings:
    """Where parts of a surface are before a camera, in its frame."""

    points: NDArray[np.float32]  # (k, 3) [m]
    normals: NDArray[np.float32]  # (k, 3)

    @staticmethod
    def of(surface: RayMesh, index: NDArray[np.int64], T_world_camera: Array) -> "Facings":
        """Points `index` (k,) of a surface."""
        R = T_world_camera[:3, :3].astype(np.float32)
        return Facings(surface.points(index, T_world_camera).T, surface.normals[:, index].T @ R)


@dataclass(frozen=True)
class Lighting:
    """Light that stands still before a camera."""

    # centre, size: of what it falls on, in the camera's frame (3,) [m], [m]
    centre: Array
    size: float
    numbers: Array  # (TERMS, 3) of the logarithm of each channel
    known: Array  # (2, 3) the least and the most that images show of it

    def brighter(self, factor: float) -> "Lighting":
        """The same light, some times as bright."""
        numbers, more = self.numbers.copy(), float(np.log(factor))
        numbers[0] += more
        return replace(self, numbers=numbers, known=self.known + more)

    def on(self, facing: Facings) -> NDArray[np.float32]:
        """(k, 3) how many times as bright as in a texture a surface looks."""
        found = terms(facing, self.centre, self.size) @ self.numbers
        return np.exp(np.clip(found, *self.known)).astype(np.float32)


def terms(facing: Facings, centre: Array, size: float) -> Array:
    """(k, TERMS) of the polynomial; the first is 1."""
    x, y, z = facing.normals.T.astype(float)
    one = np.ones_like(x)
    way = np.stack([one, x, y, z, x * y, y * z, z * x, x * x - y * y, 3 * z * z - 1], axis=1)
    place = np.column_stack([one, (facing.points - centre) / size])
    return np.asarray((place[:, :, None] * way[:, None]).reshape(len(x), TERMS))
