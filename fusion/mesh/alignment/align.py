"""A mesh laid on its reference from any pose: guesses first, then robust point-to-plane ICP, with scale if asked."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit  # scipy.stats takes a second to import

from fusion.mesh.alignment.coarse import ALIKE, NEAR, CoarseSurface, apart, guesses, score
from fusion.mesh.alignment.fit import SurfaceFit
from fusion.mesh.alignment.similarity import (
    AS_WELL,
    IDENTITY,
    Array,
    Matches,
    Similarity,
    free_shifts,
    solve,
    tells_scale,
)
from fusion.mesh.comparison.distances import CloudSurface, Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface, smooth_normals
from fusion.mesh.mesh import Mesh

_COARSE_POINTS, _FINE_POINTS, _STAND_IN = 3000, 20_000, 20_000
_SCORED = 1e-4  # of the size: poses of exact shapes that belong together score alike but for this
_POOR = 0.9  # of the score's limit per surface: one shown whole by the other scores at most 1 (guess)
# parts along x, y, z: cubes, as errors may reach across half of the object or be gone after a few pixels; and slabs,
# as what has no counterpart (a plate below) pulls at one end
_PARTS = ((2, 2, 2), (3, 3, 3), (4, 4, 4), (6, 6, 6), (6, 1, 1), (1, 6, 1), (1, 1, 6))
_FLOAT = 1e-7  # closest points are float32


def scale_interval(scale: float, scale_back: float, matches: Matches) -> tuple[float, float]:
    """95 % interval of the scale; (0, inf) where the shape says nothing about it.

    Two parts, added as squares. The random one is a jackknife over blocks of space (as cluster-robust as CR3 of Bell
    and McCaffrey 2002), at several sizes of blocks, the widest of which counts: blocks smaller than the reach of the
    errors make them look independent. The other one is how far the scale moves when the reference is laid on the
    mesh instead of the mesh on the reference: noise rounds edges and swells what is curved, in one direction and in
    the other one differently, and what has no counterpart pulls in one direction only.

    Args:
        scale: of the mesh, as fitted by laying it on the reference.
        scale_back: of the mesh, as fitted by laying the reference on it.
        matches: of the first fit, points of the mesh and where they belong on the reference.
    """
    if np.count_nonzero(matches.weights) < 8 or not tells_scale(matches):
        return 0.0, float("inf")
    random = max(_jackknife(matches, parts) for parts in _PARTS)
    half = float(np.hypot(random, np.log(scale_back / scale))) + _FLOAT
    return scale * float(np.exp(-half)), scale * float(np.exp(half))


def _jackknife(matches: Matches, parts: tuple[int, int, int]) -> float:
    """Half of the 95 % interval of the scale's logarithm, from leaving out one block of space after the other."""
    jacobian, residual, _, size = matches.rows()
    counted = np.flatnonzero(matches.weights > 0)
    jacobian, residual, weights = jacobian[counted], residual[counted], matches.weights[counted]
    block = _blocks(matches.points[counted], parts)
    weighted = jacobian * weights[:, None]
    systems = np.stack([weighted[rows].T @ jacobian[rows] for rows in block])
    rights = np.stack([weighted[rows].T @ residual[rows] for rows in block])
    share = np.array([weights[rows].sum() for rows in block]) / weights.sum()
    effective = 1 / float(np.square(share).sum())  # blocks of equal weight that say as much
    if len(block) < 3 or effective < 2:
        return 0.0  # said by the other sizes
    system, right = systems.sum(axis=0), rights.sum(axis=0)
    whole = solve(system, right)[6] / size
    without = np.array([solve(system - a, right - b)[6] for a, b in zip(systems, rights, strict=True)]) / size
    error = float(np.sqrt((len(block) - 1) / len(block) * np.square(without - whole).sum()))
    return float(stdtrit(effective - 1, 0.975)) * error


def _blocks(points: Array, parts: tuple[int, int, int]) -> list[Array]:
    """Rows of the points in each of the cells that cut their box into parts along x, y, z."""
    low, extent = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-12)
    place = np.minimum((points - low) / extent * parts, np.array(parts) - 1).astype(int)
    cell = place @ [1, parts[0], parts[0] * parts[1]]
    order = np.argsort(cell, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(cell[order])) + 1)


@dataclass(frozen=True)
class Alignment:
    """How a mesh lies on its reference: a point p of the mesh lies at `scale * R p + t`."""

    T_reference_mesh: Array  # (4, 4), rotation R and translation t [m] only
    scale: float = 1.0  # 1 unless it was fitted
    # 95 % interval of the scale, with errors that are alike in neighbouring places; None unless fitted. An error that
    # is the same all over (a depth offset) cannot be told from scale and is not in it.
    scale_interval: tuple[float, float] | None = None
    inlier_share: float = 1.0  # 0-1, of the mesh's surface that had a say in the last step
    status: str = "kept"  # "kept" (the pose it stood in was right but for the last bit), "moved", "poor" (no pose fits)
    # angles [rad], least first, by which the mesh may be turned besides and fits as well; none for a pose that was kept
    turns: tuple[float, ...] = ()
    # how far [m] the mesh may slide along the reference at least and fits as well; 0 for a pose that was kept
    slides: float = 0.0

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

    looks = smooth_normals(coarse)

    def judged(pose: Similarity) -> tuple[float, float, float, float]:
        """Scores of both surfaces and of the mesh; the mesh's by what looks the other way, and the same way [m]."""
        turned = _turned(pose, looks)
        found = fit.surface.closest(pose.apply(coarse.points), turned)
        again = quick.closest(pose.apply_inverse(asked.points), asked.normals).distances * pose.scale
        limit = NEAR * size
        near = limit - np.minimum(np.abs(found.distances), limit)
        along = np.zeros(1) if turned is None else np.sign(np.einsum("ij,ij->i", turned, found.normals))
        both, own = score(found.distances, again, limit), score(found.distances, np.zeros(1), limit)
        return both, own, float((near * (along < 0)).mean()), float((near * (along > 0)).mean())

    starts = [IDENTITY, *guesses(CoarseSurface.of(coarse), CoarseSurface.of(back))]
    poses = [fit.run(coarse, start, scale, rounds=20)[0] for start in starts]
    plain, near, against, along = np.array([judged(pose) for pose in poses]).T
    scores = plain + against  # the top of a thin plate is not its bottom from inside
    if AS_WELL * (plain + along).min() < scores.min():  # the mesh, or the reference, is inside out
        scores = plain + along
    best = int(np.argmin(scores))
    as_well = scores - scores[best] <= (AS_WELL - 1) * near[best] + _SCORED * size
    if scores[0] <= AS_WELL * scores[best] + _SCORED * size:
        best = 0
    pose, matches = SurfaceFit(other, size, facing=True).run(fine, poses[best], scale, rounds=60)
    moved = 2 * np.sin(_angle(pose) / 2) * size + np.linalg.norm(pose.apply(origin[None])[0] - origin)
    status = (
        "poor" if judged(pose)[0] > _POOR * NEAR * size else "kept" if best == 0 and moved < 0.1 * size else "moved"
    )
    interval = None
    if scale:  # the other way round: the reference on the mesh
        again = SurfaceFit(own, size / pose.scale, facing=True).run(back, pose.inverse(), scale, rounds=15)[0]
        interval = scale_interval(pose.scale, 1 / again.scale, matches)
    angles = [apart(pose, poses[k]) for k in np.flatnonzero(as_well)] if status == "moved" else []
    turns = tuple(sorted(angle for angle in angles if angle > ALIKE))
    slides = 0.0
    if status == "moved":
        best_score, best_near, *_ = judged(pose)
        limit = best_score + (AS_WELL - 1) * best_near + _SCORED * size
        ways = [Similarity(pose.rotation, pose.shift + NEAR * size * way, pose.scale) for way in free_shifts(matches)]
        slides = NEAR * size if any(judged(way)[0] <= limit for way in ways) else 0.0
    return Alignment(pose.matrix(), pose.scale, interval, float((matches.weights > 0).mean()), status, turns, slides)


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
