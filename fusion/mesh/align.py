"""A mesh laid on its reference from any pose: guesses first, then robust point-to-plane ICP, with scale if asked."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit  # scipy.stats takes a second to import

from fusion.mesh.coarse import NEAR, Side, guesses, score
from fusion.mesh.distances import Surface, surface_of
from fusion.mesh.mesh import Mesh
from fusion.mesh.similarity import IDENTITY, Array, Matches, Similarity, solve, step, tukey
from fusion.mesh.surface_samples import Samples, sample_surface

_COARSE_POINTS, _FINE_POINTS = 3000, 20_000
_PREFERENCE = 1.2  # the pose as it stands wins unless another is better by this: symmetric shapes stay (guess)
_TUKEY = 4.685  # limit in standard deviations: 95 % as efficient as least squares on Gaussian noise
_POOR = 0.9  # of the score's limit per surface: one shown whole by the other scores at most 1 (guess)


@dataclass(frozen=True)
class Alignment:
    """How a mesh lies on its reference: a point p of the mesh lies at `scale * R p + t`.

    Attributes:
        T_reference_mesh: (4, 4), rotation R and translation t [m] only.
        scale: 1 unless it was fitted.
        scale_interval: 95 % interval of the scale, from leaving out parts of the surface; None unless fitted.
        inlier_share: 0-1, of the mesh's surface that had a say in the last step.
        status: "kept" (the pose it stood in was right but for the last bit), "moved", "poor" (no pose fits).
    """

    T_reference_mesh: Array
    scale: float = 1.0
    scale_interval: tuple[float, float] | None = None
    inlier_share: float = 1.0
    status: str = "kept"

    def similarity(self) -> Similarity:
        """The same as a map of points."""
        return Similarity(self.T_reference_mesh[:3, :3], self.T_reference_mesh[:3, 3], self.scale)


def align_meshes(
    mesh: Mesh, reference: Mesh, scale: bool = False, surfaces: tuple[Surface, Surface] | None = None
) -> Alignment:
    """Lay a mesh or point cloud on a reference, from any relative pose; the same input gives the same result.

    Args:
        mesh, reference: in the same unit [m]; either may be a part of the other.
        scale: find one scale too, within 0.8 to 1.25.
        surfaces: `surface_of` both, when they are made already.

    Raises:
        MeshError: a surface without area, or too few points.
    """
    own, other = surfaces or (surface_of(mesh), surface_of(reference))
    # about the reference's middle, so that far-away coordinates lose no digits
    origin = (reference.vertices.min(axis=0) + reference.vertices.max(axis=0)) / 2
    size = float(np.linalg.norm(np.ptp(reference.vertices, axis=0)))
    coarse, fine = sample_surface(mesh, _COARSE_POINTS), sample_surface(mesh, _FINE_POINTS)
    back = sample_surface(reference, _COARSE_POINTS)
    fit = _Fit(other, origin, size)

    def judged(pose: Similarity) -> float:
        there = other.closest(pose.apply(coarse.points), _turned(pose, coarse.normals)).distances
        again = own.closest(pose.apply_inverse(back.points), back.normals).distances * pose.scale
        return score(there, again, NEAR * size)

    starts = [IDENTITY, *guesses(Side.of(coarse), Side.of(back))]
    poses = [fit.run(coarse, start, scale, rounds=20)[0] for start in starts]
    scores = [judged(pose) for pose in poses]
    best = int(np.argmin(scores))
    if scores[0] <= _PREFERENCE * scores[best] + 1e-5 * size:
        best = 0
    pose, matches = fit.run(fine, poses[best], scale, rounds=60)
    moved = 2 * np.sin(_angle(pose) / 2) * size + np.linalg.norm(pose.apply(origin[None])[0] - origin)
    status = "poor" if judged(pose) > _POOR * NEAR * size else "kept" if best == 0 and moved < 0.1 * size else "moved"
    interval = _scale_interval(pose, matches) if scale else None
    return Alignment(pose.matrix(), pose.scale, interval, float((matches.weights > 0).mean()), status)


@dataclass(frozen=True)
class _Fit:
    """ICP against one reference, of size `size` [m] about `origin` (3,)."""

    surface: Surface
    origin: Array
    size: float

    def run(self, samples: Samples, pose: Similarity, scale: bool, rounds: int) -> tuple[Similarity, Matches]:
        """Steps until nothing moves any more; the limit of the weights only shrinks, down to the noise."""
        limit = 3 * NEAR * self.size
        for _ in range(rounds):
            matches, limit = self._matches(samples, pose, limit)
            pose, moved = step(pose, matches, scale)
            if moved < 1e-8 * self.size:
                break
        return pose, self._matches(samples, pose, limit)[0]

    def _matches(self, samples: Samples, pose: Similarity, limit: float) -> tuple[Matches, float]:
        points = pose.apply(samples.points)
        found = self.surface.closest(points, _turned(pose, samples.normals))
        distance = np.abs(found.distances)
        usable = ~found.on_border  # beyond the reference's end there is nothing to lie on
        if usable.mean() < 0.2:
            usable = np.ones_like(usable)
        # the spread of those still counted: outliers are left behind, round by round
        core = distance[usable & (distance < limit)]
        spread = 1.4826 * float(np.median(core)) if len(core) else self.size
        limit = min(limit, max(_TUKEY * spread, 1e-5 * self.size))
        return Matches(points, found.points, found.normals, tukey(distance, limit) * usable), limit


def _turned(pose: Similarity, normals: Array | None) -> Array | None:
    return None if normals is None else normals @ pose.rotation.T


def _angle(pose: Similarity) -> float:
    return float(np.linalg.norm(Rotation.from_matrix(pose.rotation).as_rotvec()))


def _scale_interval(pose: Similarity, matches: Matches) -> tuple[float, float]:
    """95 % by a jackknife over 5 x 5 x 5 blocks of space: the error of a scan is alike in one place, unlike noise."""
    jacobian, residual, _, size = matches.rows()
    low, extent = matches.points.min(axis=0), np.maximum(np.ptp(matches.points, axis=0), 1e-12)
    cell = np.minimum((matches.points - low) / extent * 5, 4).astype(int) @ [1, 5, 25]
    blocks = [np.flatnonzero((cell == c) & (matches.weights > 0)) for c in np.unique(cell)]
    blocks = [block for block in blocks if len(block)]
    weighted = jacobian * matches.weights[:, None]
    systems = [weighted[b].T @ jacobian[b] for b in blocks]
    rights = [weighted[b].T @ residual[b] for b in blocks]
    system, right, count = np.sum(systems, axis=0), np.sum(rights, axis=0), len(blocks)
    if count < 3:
        return (0.0, float("inf"))
    without = np.array([solve(system - a, right - b)[6] for a, b in zip(systems, rights, strict=True)]) / size
    error = float(np.sqrt((count - 1) / count * np.square(without - without.mean()).sum()))
    half = float(stdtrit(count - 1, 0.975)) * error + 1e-7  # closest points are float32
    return pose.scale * float(np.exp(-half)), pose.scale * float(np.exp(half))
