"""One pass as the alignment sees it: points on its surface, a tree of them, and what its frames looked through."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface, smooth_normals
from fusion.passes.one_pass import Pass
from fusion.passes.poses.outlook import Outlook

Array = NDArray[np.float64]
DENSE, FEW = 20_000, 1500  # points that stand for the surface, and that are laid on it (spread: 2 %)
REACHED = 2.5  # spacings of the dense points beside one of them that still lie on the surface


@dataclass(frozen=True)
class PassSide:
    """A pass's surface in its own object frame."""

    # points, normals: (m, 3) dense; normals averaged over neighbours
    points: Array
    normals: Array
    tree: cKDTree  # of the dense points
    spacing: float  # between neighbouring dense points [m]
    few: SurfaceSamples  # about FEW of them, evenly
    size: float  # diagonal of the box of the points [m]
    noise: float  # distance [m] within which two passes lie on each other
    outlook: Outlook  # what its frames looked through
    plate: bool  # it stood on a plate at z = 0: nothing of the object is below

    def empty(self, points: Array, normals: Array | None = None) -> NDArray[np.bool_]:
        """(n,) bool: places (n, 3) that its frames looked through, or below its plate."""
        below = points[:, 2] < -self.noise if self.plate else np.zeros(len(points), bool)
        return np.asarray(self.outlook.through(points, normals) | below)

    def nearest(self, points: Array, reach: float) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Index (n,) of the dense point nearest to each of points (n, 3), and whether one is within the reach [m]."""
        distance, index = self.tree.query(points, distance_upper_bound=reach)
        known = np.isfinite(distance)
        return np.where(known, index, 0), known


def side_of(one: Pass) -> PassSide:
    """The surface of a pass, made ready."""
    dense = sample_surface(one.mesh, DENSE)
    normals = smooth_normals(dense)
    assert normals is not None  # triangles have some
    tree = cKDTree(dense.points)
    spacing = float(np.median(tree.query(dense.points[::20], k=2)[0][:, 1]))
    step = max(1, len(dense.points) // FEW)
    return PassSide(
        dense.points,
        normals,
        tree,
        spacing,
        SurfaceSamples(dense.points[::step], normals[::step]),
        float(np.linalg.norm(np.ptp(dense.points, axis=0))),
        one.near,
        one.outlook,
        one.plate,
    )
