"""A triangle mesh as plain arrays."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Mesh:
    """Triangles, or a point cloud when there are no faces.

    Attributes:
        vertices: (n, 3) float64 [m].
        faces: (m, 3) int32, counter-clockwise seen from outside; (0, 3) for a point cloud.
        normals: (n, 3) float32 unit vectors pointing outwards, or None.
        colors: (n, 3) uint8 RGB, or None.
        scalars: named values per vertex, each (n,) float32.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    normals: NDArray[np.float32] | None = None
    colors: NDArray[np.uint8] | None = None
    scalars: dict[str, NDArray[np.float32]] = field(default_factory=dict)
