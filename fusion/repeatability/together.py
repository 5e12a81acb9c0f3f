"""All scans laid on each other at once: every one pulls at every other, and none is the reference.

Point to plane over all pairs of scans (Chen and Medioni 1991; for many surfaces together Pulli 1999), one linear system
in the small motions of all. Of the motions that fit equally well, all moving together, the smallest is taken.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import robust_std
from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface
from fusion.mesh.mesh import Mesh
from fusion.progress import each, stage

Array = NDArray[np.float64]
POINTS = 6000  # of each scan, that meet each other one
PARTNERS = 6  # scans that each is laid on directly; in a ring where there are more
ROUNDS = 12
SETTLED = 1e-7  # [rad], [m]
CUT = 4.0  # robust standard deviations beyond which a pair has no say
SAME_SIDE = 0.5  # least cosine between normals of a pair
FEWEST = 100  # pairs of points that hold two scans together


@dataclass(frozen=True)
class Together:
    """Scans in one frame."""

    poses: Array  # (n, 4, 4) `T_common_scan`
    surfaces: list[Surface]  # of the scans, each in its own frame
    status: list[str]  # "kept", "moved" or "poor" of each, from its first alignment


def lay_together(meshes: list[Mesh]) -> Together:
    """Lay meshes of one object on each other, from any pose."""
    surfaces = [surface_of(mesh) for mesh in meshes]
    poses, status = [np.eye(4)], ["kept"]
    with stage("aligning"):
        for mesh, surface in zip(each(meshes[1:], "aligning"), surfaces[1:], strict=True):
            found = align_meshes(mesh, meshes[0], surfaces=(surface, surfaces[0]), least=True)
            poses.append(found.T_reference_mesh)
            status.append(found.status)
        samples = [sample_surface(mesh, POINTS, seed=k) for k, mesh in enumerate(meshes)]
        placed = np.array(poses)
        for _ in range(ROUNDS):
            step = _step(placed, samples, surfaces)
            placed = _moved(placed, step, _middle(placed, samples))
            if np.abs(step).max() < SETTLED:
                break
    return Together(placed, surfaces, status)


def _pairs(n: int) -> list[tuple[int, int]]:
    """Which scan's points meet which scan's surface."""
    reach = min(n - 1, PARTNERS)
    return [(i, (i + k) % n) for i in range(n) for k in range(1, reach + 1)]


def _step(poses: Array, samples: list[SurfaceSamples], surfaces: list[Surface]) -> Array:
    """(n, 6) small motions about the middle: rotation [rad], translation [m]."""
    n, middle = len(poses), _middle(poses, samples)
    H, g = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
    for i, j in _pairs(n):
        J, r = _equations(poses[i], poses[j], samples[i], surfaces[j], middle)
        if len(r) < FEWEST:
            continue
        own, other = slice(6 * i, 6 * i + 6), slice(6 * j, 6 * j + 6)
        A, b = J.T @ J / len(r), J.T @ r / len(r)
        H[own, own] += A
        H[other, other] += A
        H[own, other] -= A
        H[other, own] -= A
        g[own] += b
        g[other] -= b
    size = np.sqrt(np.maximum(np.diag(H), 1e-12))
    inverse = np.linalg.pinv(H / np.outer(size, size), rcond=1e-9, hermitian=True)
    return np.asarray(-(inverse @ (g / size)) / size).reshape(n, 6)


def _equations(
    T_own: Array, T_other: Array, own: SurfaceSamples, surface: Surface, middle: Array
) -> tuple[Array, Array]:
    """Derivatives (m, 6) in the own motion, and signed distances (m,) [m], of pairs that have a say."""
    assert own.normals is not None
    points, normals = pose.transform(T_own, own.points), own.normals @ T_own[:3, :3].T
    back = pose.inverse(T_other)
    found = surface.closest(pose.transform(back, points), normals @ back[:3, :3].T)
    across = found.normals @ T_other[:3, :3].T
    good = ~found.on_border & (np.einsum("ij,ij->i", normals, across) > SAME_SIDE)
    if not good.any():
        return np.zeros((0, 6)), np.zeros(0)
    limit = CUT * robust_std(found.distances[good]) + 1e-9
    good &= np.abs(found.distances) < limit
    J = np.hstack([np.cross(points[good] - middle, across[good]), across[good]])
    return J, found.distances[good]


def _middle(poses: Array, samples: list[SurfaceSamples]) -> Array:
    return np.asarray(pose.transform(poses[0], samples[0].points).mean(axis=0))


def _moved(poses: Array, step: Array, middle: Array) -> Array:
    """Poses after small motions about a point."""
    there, back = np.eye(4), np.eye(4)
    there[:3, 3], back[:3, 3] = middle, -middle
    return np.array([there @ pose.exp(twist) @ back @ T for T, twist in zip(poses, step, strict=True)])
