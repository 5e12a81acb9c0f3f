"""Where two surfaces that stand in any pose to each other may belong: guesses, tried by a few quick ICP steps."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from fusion.compute.process import own_process
from fusion.mesh.alignment.similarity import IDENTITY, Array, Matches, Similarity, step, tukey
from fusion.mesh.comparison.distances import workers_for
from fusion.mesh.comparison.surface_samples import SurfaceSamples

_SPREAD = 72  # rotations over the whole sphere: about 45 degrees apart, within reach of ICP (guess)
_OF_A_PART = 200  # rotations more of what may be a part, each with eight shifts, of which
_OF_PARTS = 60  # go into ICP: those that lie best at first sight, where
_ROUGH = 0.1  # of the reference's size still counts as near (guesses)
_ALSO = 24  # of those turned about the reference's box
_KEPT = 8  # guesses that come to the final choice
_TRIAL = 250  # points a guess is tried with
ALIKE = np.deg2rad(5)  # less apart, two poses are one
NEAR = 0.03  # of the reference's size: what lies on each other after a coarse alignment (guess)


@dataclass(frozen=True)
class CoarseSurface:
    """One surface for the coarse search: its samples, as a tree; normals are None for bare point clouds."""

    points: Array
    normals: Array | None
    tree: cKDTree

    @cached_property
    def size(self) -> float:
        """Diagonal of its box [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @classmethod
    def of(cls, samples: SurfaceSamples) -> "CoarseSurface":
        return cls(samples.points, samples.normals, cKDTree(samples.points))


def guesses(mesh: CoarseSurface, reference: CoarseSurface) -> list[Similarity]:
    """The most promising poses, best first: at most `_KEPT`, none twice. The same input gives the same list."""
    few = mesh.points[np.linspace(0, len(mesh.points) - 1, min(_TRIAL, len(mesh.points))).astype(int)]
    back = reference.points[np.linspace(0, len(reference.points) - 1, min(_TRIAL, len(reference.points))).astype(int)]

    rated = rating(mesh, reference, few, back, NEAR)
    rough = rating(mesh, reference, few[::3], back[::3], _ROUGH)
    turns = [*_axes_on_axes(mesh, reference), *Rotation.random(_OF_A_PART, random_state=2).as_matrix()]
    parts = _sorted(_of_parts(mesh, reference, turns), rough)[:_OF_PARTS]
    tried = [_quick_icp(few, reference, guess, range(4)) for guess in (*_all(mesh, reference), *parts)]
    tried = _sorted(tried, rated)[: len(tried) // 3]
    tried = _sorted([_quick_icp(few, reference, guess, range(4, 10)) for guess in tried], rated)
    alike = _sorted(_of_parts(mesh, reference, _turned(tried[0].rotation, reference)), rough)[:_ALSO]
    tried = _sorted([*tried, *(_quick_icp(few, reference, guess, range(2, 10)) for guess in alike)], rated)
    kept: list[Similarity] = []
    for guess in tried:
        if all(apart(guess, other) > ALIKE for other in kept):
            kept.append(guess)
        if len(kept) == _KEPT:
            break
    return kept


def rating(
    mesh: CoarseSurface, reference: CoarseSurface, few: Array, back: Array, near: float
) -> Callable[[Sequence[Similarity]], Array]:
    """What rates poses (k,): the `score` of few points (n, 3) of the mesh and of the reference, `near` in its sizes.

    All at once, and what is far is not looked for: most of the time of a coarse search went into single look-ups.
    """
    limit = near * reference.size

    def distances(tree: cKDTree, places: list[Array], reach: float) -> Array:
        all_of = np.stack(places)
        workers = workers_for(all_of.size // 3)
        return np.asarray(tree.query(all_of, distance_upper_bound=reach, workers=workers)[0])

    def rated(poses: Sequence[Similarity]) -> Array:
        scales = np.array([[pose.scale] for pose in poses])
        there = distances(reference.tree, [pose.apply(few) for pose in poses], limit)
        again = distances(mesh.tree, [pose.apply_inverse(back) for pose in poses], limit / scales.min())
        return score(there, scales * again, limit)

    return rated


def _sorted(poses: Iterable[Similarity], rated: Callable[[Sequence[Similarity]], Array]) -> list[Similarity]:
    """The best first."""
    poses = list(poses)
    return [poses[k] for k in np.argsort(rated(poses), kind="stable")]


def score(there: Array, again: Array, limit: float) -> Array:
    """Mean distances (...) [m] of the mesh (..., n) plus those of the reference, nothing counted more than `limit` [m].

    So it does not matter how far away the rest of a mesh or reference is that shows more than the other one.
    """
    return np.asarray(np.minimum(np.abs(there), limit).mean(axis=-1) + np.minimum(np.abs(again), limit).mean(axis=-1))


def _all(mesh: CoarseSurface, reference: CoarseSurface) -> Iterator[Similarity]:
    yield IDENTITY
    here, there = mesh.points.mean(axis=0), reference.points.mean(axis=0)
    for turn in (*_axes_on_axes(mesh, reference), np.eye(3), *Rotation.random(_SPREAD, random_state=1).as_matrix()):
        yield Similarity(turn, there - turn @ here)
    yield from by_features(mesh, reference)


def _of_parts(mesh: CoarseSurface, reference: CoarseSurface, turns: Iterable[Array]) -> Iterator[Similarity]:
    """Poses of a part of the object: its middle says little, but along each axis it mostly shows one end whole."""
    ends = np.stack([reference.points.min(axis=0), reference.points.max(axis=0)])
    for turn in turns:
        points = mesh.points @ turn.T
        shifts = ends - np.stack([points.min(axis=0), points.max(axis=0)])
        for choice in product((0, 1), repeat=3):
            yield Similarity(turn, shifts[choice, range(3)])


def _turned(found: Array, reference: CoarseSurface) -> Iterator[Array]:
    """A rotation that was found, turned about the reference's own box: poses that look alike mostly differ so."""
    axes = box_axes(reference.points)
    return (axes @ cube @ axes.T @ found for cube in _cube_rotations())


def box_axes(points: Array) -> Array:
    """(3, 3) columns: axes of about the smallest box around points (n, 3)."""
    import open3d

    few = points[::12]  # the smallest box takes seconds to find of what is round
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(few))
    return np.array(cloud.get_minimal_oriented_bounding_box(robust=True).R)


def _axes_on_axes(mesh: CoarseSurface, reference: CoarseSurface) -> list[Array]:
    """The rotations that lay the mesh's principal axes on those of the reference."""
    axes, target = principal_axes(mesh.points), principal_axes(reference.points)
    return [target @ cube @ axes.T for cube in _cube_rotations()]


def principal_axes(points: Array) -> Array:
    """(3, 3) columns: principal axes of points (n, 3), a rotation."""
    axes = np.linalg.eigh(np.cov(points.T))[1]
    return axes * np.sign(np.linalg.det(axes))


def _cube_rotations() -> list[Array]:
    """The 24 ways to lay three axes on three axes."""
    found = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.eye(3)[list(order)] * np.array(signs)[:, None]
        if np.linalg.det(turn) > 0:
            found.append(turn)
    return found


def by_features(mesh: CoarseSurface, reference: CoarseSurface) -> Iterator[Similarity]:
    """Poses by local shape (FPFH, fast global registration), for parts whose middles say little."""
    import open3d

    if own_process():  # of pairs that do not fit it warns, through Python's own output
        open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)

    o3d: Any = open3d  # its stubs know no default arguments
    if mesh.normals is None or reference.normals is None:
        return
    registration = o3d.pipelines.registration
    size = reference.size
    for share in (0.03, 0.06):
        clouds, features = [], []
        for side in (mesh, reference):
            cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(side.points))
            cloud.normals = o3d.utility.Vector3dVector(side.normals)
            cloud = cloud.voxel_down_sample(share * size)
            near = o3d.geometry.KDTreeSearchParamHybrid(radius=4 * share * size, max_nn=100)
            features.append(registration.compute_fpfh_feature(cloud, near))
            clouds.append(cloud)
        if min(len(cloud.points) for cloud in clouds) < 20:
            continue
        o3d.utility.random.seed(0)
        option = registration.FastGlobalRegistrationOption(maximum_correspondence_distance=share * size)
        try:
            found = registration.registration_fgr_based_on_feature_matching(*clouds, *features, option).transformation
        except RuntimeError:  # too few matches: no guess from here
            continue
        if np.isfinite(found).all():
            yield Similarity(np.array(found[:3, :3]), np.array(found[:3, 3]))


def _quick_icp(points: Array, reference: CoarseSurface, now: Similarity, rounds: range) -> Similarity:
    size = reference.size
    for number in rounds:
        moved = now.apply(points)
        distance, index = reference.tree.query(moved)
        targets = reference.points[index]
        normals = moved - targets if reference.normals is None else reference.normals[index]
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        # from the shape's size down to what counts as near, else a plate around the object would pull it away
        weights = tukey(distance, min(3 * float(np.quantile(distance, 0.7)) + 1e-12, size * 0.25 * 0.75**number))
        now, _ = step(now, Matches(moved, targets, normals, weights), scale=False)
    return now


def apart(one: Similarity, other: Similarity) -> float:
    """The angle between two poses [rad]."""
    cosine = (np.sum(one.rotation * other.rotation) - 1) / 2
    return float(np.arccos(np.clip(cosine, -1, 1)))
