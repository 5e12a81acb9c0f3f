"""A mesh laid on its reference from any pose: guesses first, then robust point-to-plane ICP, with scale if asked."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.mesh.alignment.coarse import NEAR, CoarseSurface, guesses, score
from fusion.mesh.alignment.fit import SurfaceFit
from fusion.mesh.alignment.scale_interval import scale_interval
from fusion.mesh.alignment.similarity import IDENTITY, Array, Similarity
from fusion.mesh.comparison.distances import CloudSurface, Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface, smooth_normals
from fusion.mesh.mesh import Mesh

_COARSE_POINTS, _FINE_POINTS, _STAND_IN = 3000, 20_000, 20_000
_PREFERENCE = 1.2  # the pose as it stands wins unless another is better by this: symmetric shapes stay (guess)
_POOR = 0.9  # of the score's limit per surface: one shown whole by the other scores at most 1 (guess)


@dataclass(frozen=True)
class Alignment:
    """How a mesh lies on its reference: a point p of the mesh lies at `scale * R p + t`.

    Attributes:
        T_reference_mesh: (4, 4), rotation R and translation t [m] only.
        scale: 1 unless it was fitted.
        scale_interval: 95 % interval of the scale, with errors that are alike in neighbouring places; None unless
            fitted. An error that is the same all over (a depth offset) cannot be told from scale and is not in it.
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
    mesh: Mesh,
    reference: Mesh,
    scale: bool = False,
    surfaces: tuple[Surface, Surface] | None = None,
    seen: Array | None = None,
) -> Alignment:
    """Lay a mesh or point cloud on a reference, from any relative pose; the same input gives the same result.

    Args:
        mesh, reference: in the same unit [m]; either may be a part of the other.
        scale: find one scale too, within 0.8 to 1.25.
        surfaces: `surface_of` both, when they are made already.
        seen: (n, 3) points of the reference that the mesh ought to show: they tell a box with an open bottom from the
            same one upside down.

    Raises:
        MeshError: a surface without area, or too few points.
    """
    own, other = surfaces or (surface_of(mesh), surface_of(reference))
    # about the reference's middle, so that far-away coordinates lose no digits
    origin = (reference.vertices.min(axis=0) + reference.vertices.max(axis=0)) / 2
    size = float(np.linalg.norm(np.ptp(reference.vertices, axis=0)))
    coarse, fine = sample_surface(mesh, _COARSE_POINTS), sample_surface(mesh, _FINE_POINTS)
    back = sample_surface(reference, _COARSE_POINTS)
    asked = (
        back if seen is None or not len(seen) else SurfaceSamples(seen[:: max(1, len(seen) // _COARSE_POINTS)], None)
    )
    fine = SurfaceSamples(fine.points, smooth_normals(fine))
    fit = SurfaceFit(_quick(reference, other), size)
    quick = _quick(mesh, own)

    def judged(pose: Similarity) -> float:
        there = fit.surface.closest(pose.apply(coarse.points), _turned(pose, coarse.normals)).distances
        again = quick.closest(pose.apply_inverse(asked.points), asked.normals).distances * pose.scale
        return score(there, again, NEAR * size)

    starts = [IDENTITY, *guesses(CoarseSurface.of(coarse), CoarseSurface.of(back))]
    poses = [fit.run(coarse, start, scale, rounds=20)[0] for start in starts]
    scores = [judged(pose) for pose in poses]
    best = int(np.argmin(scores))
    if scores[0] <= _PREFERENCE * scores[best] + 1e-5 * size:
        best = 0
    pose, matches = SurfaceFit(other, size, facing=True).run(fine, poses[best], scale, rounds=60)
    moved = 2 * np.sin(_angle(pose) / 2) * size + np.linalg.norm(pose.apply(origin[None])[0] - origin)
    status = "poor" if judged(pose) > _POOR * NEAR * size else "kept" if best == 0 and moved < 0.1 * size else "moved"
    interval = None
    if scale:  # the other way round: the reference on the mesh
        again = SurfaceFit(own, size / pose.scale, facing=True).run(back, pose.inverse(), scale, rounds=15)[0]
        interval = scale_interval(pose.scale, 1 / again.scale, matches)
    return Alignment(pose.matrix(), pose.scale, interval, float((matches.weights > 0).mean()), status)


def _quick(mesh: Mesh, surface: Surface) -> Surface:
    """Stands for the surface while the pose is sought: closest points on a fine mesh are slow to find from afar."""
    if isinstance(surface, CloudSurface):
        return surface
    samples = sample_surface(mesh, _STAND_IN)
    normals = None if samples.normals is None else samples.normals.astype(np.float32)
    return CloudSurface(Mesh(samples.points, normals=normals))


def _turned(pose: Similarity, normals: Array | None) -> Array | None:
    return None if normals is None else normals @ pose.rotation.T


def _angle(pose: Similarity) -> float:
    return float(np.linalg.norm(Rotation.from_matrix(pose.rotation).as_rotvec()))
