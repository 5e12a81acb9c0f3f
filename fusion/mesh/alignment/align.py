"""A mesh laid on its reference from any pose: guesses first, then robust point-to-plane ICP, with scale if asked."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.mesh.alignment.coarse import ALIKE, NEAR, CoarseSurface, apart, guesses
from fusion.mesh.alignment.fit import SurfaceFit
from fusion.mesh.alignment.judge import PoseJudge, PoseScore
from fusion.mesh.alignment.look_alikes import MAYBE, layers, turned_alike
from fusion.mesh.alignment.scale_interval import UNKNOWN, scale_asked_for, scale_interval
from fusion.mesh.alignment.similarity import AS_WELL, IDENTITY, SCALES, Array, Similarity, free_shifts, tells_scale
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import side_by_side

_POOR = 0.9  # of the score's limit per surface: one shown whole by the other scores at most 1 (guess)
_SAME = 0.1  # of what is near: steps that go on lead from one of such poses to the other (guess)
_BEGUN, _FIRST = 1000, 6  # so many samples take so many steps first: most poses lead to the same place (guess)
_COVERED = 0.5  # of the reference, close to the mesh: it is there, whatever else the mesh shows (guess)


@dataclass(frozen=True)
class Alignment:
    """How a mesh lies on its reference: a point p of the mesh lies at `scale * R p + t`."""

    T_reference_mesh: Array  # (4, 4), rotation R and translation t [m] only
    scale: float = 1.0  # 1 unless it was fitted
    # 95 % interval of the scale, with errors that are alike in neighbouring places; None unless fitted. An error that
    # is the same all over (a depth offset) cannot be told from scale and is not in it. (0, inf) where nothing tells it,
    # or the scale is the end of what is looked for: the right one lies beyond.
    scale_interval: tuple[float, float] | None = None
    inlier_share: float = 1.0  # 0-1, of the mesh's surface that had a say in the last step
    status: str = "kept"  # "kept" (the pose it stood in was right but for the last bit), "moved", "poor" (no pose fits)
    # angles [rad], least first, by which the mesh may be turned besides and fits as well; none for a pose that was kept
    turns: tuple[float, ...] = ()
    # how far [m] the mesh may slide along the reference at least and fits as well; 0 for a pose that was kept
    slides: float = 0.0
    asks_scale: float | None = None  # by which the mesh would fit clearly better, where none was fitted

    def similarity(self) -> Similarity:
        """The same as a map of points."""
        return Similarity(self.T_reference_mesh[:3, :3], self.T_reference_mesh[:3, 3], self.scale)


def align_meshes(
    mesh: Mesh,
    reference: Mesh,
    scale: bool = False,
    surfaces: tuple[Surface, Surface] | None = None,
    seen: Array | None = None,
    least: bool = False,
    near: bool = False,
) -> Alignment:
    """Lay a mesh or point cloud on a reference, from any relative pose; the same input gives the same result.

    Args:
        mesh, reference: in the same unit [m]; either may be a part of the other.
        scale: find one scale too, within 0.8 to 1.25.
        surfaces: `surface_of` both, when they are made already.
        seen: (n, 3) points of the reference that the mesh ought to show: they tell a box with an open bottom from the
            same one upside down.
        least: of poses that fit as well take the one that turns the mesh least, as of scans that were set up alike.
        near: they stand in one frame but for small errors: others are looked for only where that does not fit.

    Raises:
        MeshError: a surface without area, or too few points.
    """
    own, other = surfaces or (surface_of(mesh), surface_of(reference))
    # about the reference's middle, so that far-away coordinates lose no digits
    origin = (reference.vertices.min(axis=0) + reference.vertices.max(axis=0)) / 2
    size = float(np.linalg.norm(np.ptp(reference.vertices, axis=0)))
    judge = PoseJudge(mesh, reference, (own, other), size, seen)
    likely = (_standing(judge, scale) if near else None) or _likely(judge, scale, least)
    pose, matches = judge.exact.run(judge.fine, likely.pose, scale, rounds=60)
    if scale and pose.scale != 1 and not tells_scale(matches):  # what moved it was not this shape's
        pose = Similarity(pose.rotation, origin - pose.rotation @ pose.apply_inverse(origin[None])[0])
        pose, matches = judge.exact.run(judge.fine, pose, False, rounds=60)
    moved = 2 * np.sin(_angle(pose) / 2) * size + np.linalg.norm(pose.apply(origin[None])[0] - origin)
    poor = _poor(judge.score(pose), size)
    status = "poor" if poor else "kept" if likely.stands and moved < 0.1 * size else "moved"
    interval, asks = None, None if scale or poor else scale_asked_for(matches)
    if scale:  # the other way round: the reference on the mesh
        again = SurfaceFit(own, size / pose.scale, facing=True).run(judge.back, pose.inverse(), scale, rounds=15)[0]
        outside = any(np.isclose(pose.scale, end, rtol=1e-6) for end in SCALES)  # at the end nothing was found
        interval = UNKNOWN if outside else scale_interval(pose.scale, 1 / again.scale, matches)
    angles = [apart(pose, other) for other in likely.alike] if status == "moved" else []
    turns = tuple(sorted(angle for angle in angles if angle > ALIKE))
    slides = 0.0
    if status == "moved":
        still = judge.cost(pose)
        ways = [Similarity(pose.rotation, pose.shift + NEAR * size * way, pose.scale) for way in free_shifts(matches)]
        slides = NEAR * size if any(judge.cost(way).as_well(still, size) for way in ways) else 0.0
    had_a_say = float((matches.weights > 0).mean())
    return Alignment(pose.matrix(), pose.scale, interval, had_a_say, status, turns, slides, asks)


class _Likely(NamedTuple):
    pose: Similarity
    stands: bool  # it is about the one that the mesh stood in
    alike: list[Similarity]  # that fit as well, itself among them


def _standing(judge: PoseJudge, scale: bool) -> _Likely | None:
    """The pose that the mesh stands in, but for the last steps; None where it does not fit there."""
    pose = judge.refined(judge.rough.run(judge.coarse, IDENTITY, scale, rounds=20)[0], scale)
    return None if _poor(judge.score(pose), judge.size) else _Likely(pose, True, [pose])


def _likely(judge: PoseJudge, scale: bool, least: bool) -> _Likely:
    """The best pose but for the last steps, and what cannot be told from it."""
    mesh, reference = CoarseSurface.of(judge.coarse), CoarseSurface.of(judge.back)

    def steps(starts: list[Similarity], samples: SurfaceSamples, rounds: int) -> list[Similarity]:
        return side_by_side(lambda start: judge.rough.run(samples, start, scale, rounds)[0], starts)

    def tried(starts: list[Similarity], beside: list[Similarity]) -> list[Similarity]:
        """Where they lead, once each; but for those that lead to where others have led before."""
        led: list[Similarity] = []
        for pose in steps(starts, judge.coarse.every(max(1, len(judge.coarse.points) // _BEGUN)), _FIRST):
            if not any(_one(judge, pose, other) for other in (*beside, *led)):
                led.append(pose)
        return steps(led, judge.coarse, 20)

    poses = tried([IDENTITY, *guesses(mesh, reference)], [])
    scores = side_by_side(judge.score, poses)
    nearest = int(np.argmin([one.both + one.against for one in scores]))
    first = poses[nearest]
    if _poor(scores[nearest], judge.size):  # of what does not fit, nothing like it does
        return _Likely(first, nearest == 0, [first])
    thin = layers(first, judge.exact.run(judge.coarse, first, scale, rounds=1)[1], judge.size)
    poses += tried([*turned_alike(mesh, reference, first), *thin], poses)
    scores = side_by_side(judge.score, poses)
    right = np.array([one.both + one.against for one in scores])
    wrong = np.array([one.both + one.along for one in scores])
    judge.inside_out = bool(AS_WELL * wrong.min() < right.min())
    rated = wrong if judge.inside_out else right
    room = (MAYBE - 1) * scores[int(np.argmin(rated))].own + NEAR * judge.size / np.sqrt(len(judge.back.points))
    few: list[int] = [0]
    for k in np.argsort(rated, kind="stable").tolist():
        if rated[k] <= rated.min() + room and not any(_one(judge, poses[k], poses[j]) for j in few):
            few.append(k)
    poses = side_by_side(lambda k: judge.refined(poses[k], scale), few)
    costs = side_by_side(judge.cost, poses)
    best = min(costs, key=lambda one: one.both)
    alike = [one.as_well(best, judge.size) for one in costs]
    # the pose as it stands wins unless another is clearly better: symmetric shapes stay
    chosen = 0 if alike[0] else costs.index(best)
    if least:
        chosen = min((k for k, one in enumerate(costs) if one.maybe(best)), key=lambda k: _angle(poses[k]))
    return _Likely(poses[chosen], chosen == 0, [pose for pose, same in zip(poses, alike, strict=True) if same])


def _poor(found: PoseScore, size: float) -> bool:
    """Does neither side lie on the other?"""
    return found.both > _POOR * NEAR * size and found.covered < _COVERED


def _one(judge: PoseJudge, pose: Similarity, other: Similarity) -> bool:
    """Do two poses differ by less than the last steps may take them?"""
    some = judge.coarse.points[::300]
    off = np.linalg.norm(pose.apply(some) - other.apply(some), axis=1)
    return bool(off.max() < _SAME * NEAR * judge.size)


def _angle(pose: Similarity) -> float:
    return float(np.linalg.norm(Rotation.from_matrix(pose.rotation).as_rotvec()))
