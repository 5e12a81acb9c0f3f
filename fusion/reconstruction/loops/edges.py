"""What two key frames say of each other: by their surfaces, by their landmarks, and by having been tracked."""

from collections.abc import Sequence

import numpy as np

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.geometry.robust import CUT, EFFECTIVE, robust_std, tukey
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.tracking.equations import Points
from fusion.tracking.graph import Edge
from fusion.tracking.icp import IcpSettings, align_points
from fusion.tracking.landmarks import Landmarks, meet

# errors of landmarks are alike, as those of pixels: pairs of views 10 to 20 degrees apart were off by 5 to 15 mm
# where 200 landmarks of 1 cm each promised 1 mm (a simulated room)
ALIKE = 0.02
# between neighbours, whose motion is known to some centimetres, and between views that met again; these and all lengths
# below are absolute, as they are of a hand that carries a camera, whatever it looks at
CLOSE = IcpSettings(points=(1500, 6000), reaches=(0.08, 0.03), iterations=(8, 6))
MET = IcpSettings(points=(1500, 3000, 6000), reaches=(0.25, 0.08, 0.03), iterations=(12, 8, 6))
SHARE = 0.6  # of the visible points must fit where two views are said to be of one place (guess; chance gives a third)
# an edge by surfaces alone closes a loop where its standard deviations are below these [m], [rad]: in a simulated room
# right ones had 5 to 20 mm, those that had slid along a wall 27 to 60
FIXED = 0.02, np.deg2rad(2)
DISAGREE = 0.15, np.deg2rad(5)  # [m], [rad] by which surface and landmarks may differ in what they say (guess)
# tracking from one key frame to the next may miss all of the motion, before a wall: a third of what lies between them
TRACKED = 0.05, np.deg2rad(2.5)
LEAST = 1e-6  # [m] a depth without a stated noise


def tracked_edge(frames: Sequence[Keyframe], i: int, j: int) -> Edge:
    """As both were tracked."""
    T = inverse(frames[i].T_world_camera) @ frames[j].T_world_camera
    information = np.diag(np.repeat([TRACKED[1] ** -2.0, TRACKED[0] ** -2.0], 3))
    return Edge(i, j, T, information, T[:3, 3], doubtful=True, kind="tracked")


def surface_edge(
    frames: Sequence[Keyframe],
    pair: tuple[int, int],
    T_i_j: Array,
    settings: IcpSettings,
    doubtful: bool,
    share: float = SHARE,
) -> Edge | None:
    """By the surfaces of both, from a first guess (4, 4); None where they do not fit."""
    i, j = pair
    result = align_points(frames[j].points, frames[i].surface, T_i_j, settings)
    if not result.ok or result.inlier_share < share:
        return None
    T, points = result.T_model_source, frames[j].points
    information = EFFECTIVE * by_relief(result.information, points, frames[i].surface, T, settings.reaches[-1])
    return Edge(i, j, T, information, transform(T, points.centre), doubtful, "surface", result.inlier_share)


def seen_edge(
    frames: Sequence[Keyframe], pair: tuple[int, int], shown: tuple[Landmarks, Landmarks], share: float
) -> Edge | None:
    """By landmarks of the shapes around both, and then by their surfaces, of which a share must fit."""
    i, j = pair
    met = meet(*shown)
    return None if met is None else surface_edge(frames, (i, j), met.T_a_b, MET, True, share)


def fixed(edge: Edge) -> bool:
    """An edge leaves no direction open: walls alone fit wherever one slides along them."""
    sigma = np.sqrt(np.diag(np.linalg.pinv(edge.information, hermitian=True)))
    return bool(sigma[:3].max() < FIXED[1] and sigma[3:].max() < FIXED[0])


def landmark_edge(frames: Sequence[Keyframe], i: int, j: int, doubtful: bool) -> Edge | None:
    """By their landmarks; None where too few agree, or there is no colour."""
    a, b = frames[i].landmarks, frames[j].landmarks
    met = None if a is None or b is None else meet(a, b)
    if met is None:
        return None
    return Edge(i, j, met.T_a_b, ALIKE * met.information, met.centre, doubtful, "landmarks")


def agree(a: Edge, b: Edge) -> bool:
    """Two edges of the same pair say about the same."""
    apart = inverse(a.T_i_j) @ b.T_i_j
    return bool(np.linalg.norm(apart[:3, 3]) < DISAGREE[0] and angle(apart) < DISAGREE[1])


def by_relief(information: Array, source: Points, model: PointMap, T_model_source: Array, reach: float) -> Array:
    """The information (6, 6) of an alignment that both surfaces' normals bear out; no direction has less than none.

    A wall resists sliding along itself only by the noise of its normals. Noise in both factors of a product adds up to
    a false information; the normals of two views err independently, so products of one's with the other's have no such
    part.

    Args:
        information: (6, 6) as the alignment gives it, by the model's normals alone.
        T_model_source: (4, 4) as aligned.
        reach: largest distance of a pair [m].
    """
    rows = np.moveaxis(source.lanes, 1, 0).reshape(7, -1)
    rows = rows[:, rows[6] >= 0].T.astype(float)
    points = rows[:, :3] @ T_model_source[:3, :3].T + T_model_source[:3, 3]
    normals = rows[:, 3:6] @ T_model_source[:3, :3].T
    camera = model.camera
    pixels = np.rint(camera.project(points))
    inside = np.isfinite(pixels).all(axis=1) & (points[:, 2] > 0) & (pixels >= 0).all(axis=1)
    inside &= (pixels < (camera.width, camera.height)).all(axis=1)
    u, v = pixels[inside].astype(int).T
    points, normals, sigma = points[inside], normals[inside], rows[inside, 6]
    there, theirs = model.points[v, u].astype(float), model.normals[v, u].astype(float)
    apart = np.einsum("ij,ij->i", points - there, theirs)
    met = np.linalg.norm(points - there, axis=1) < 2 * reach  # beside each other along the surface, too
    met &= np.isfinite(apart) & (np.abs(apart) < reach)
    if not met.any():
        return np.zeros((6, 6))
    spread = np.maximum(np.hypot(sigma, model.sigma[v, u])[met], LEAST)
    scale = max(robust_std(apart[met] / spread), 1.0)
    weight = tukey(apart[met] / (scale * spread), CUT) / spread**2
    arm = points[met] - (T_model_source[:3, :3] @ source.centre + T_model_source[:3, 3])
    here, other = (np.hstack([np.cross(arm, n), n]) for n in (normals[met], theirs[met]))
    both, alone = here.T @ (weight[:, None] * other), other.T @ (weight[:, None] * other)
    values, vectors = np.linalg.eigh((both + both.T) / 2 * np.trace(information) / np.trace(alone))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)
