"""What two key frames say of each other: by their surfaces, by their landmarks, and by having been tracked."""

from collections.abc import Sequence

import numpy as np

from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.geometry.robust import EFFECTIVE
from fusion.reconstruction.loops.correction import OFF
from fusion.reconstruction.loops.keyframes import Keyframe
from fusion.tracking.both_sides import by_relief
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
NONE = 1e-9  # of that: where a direction has no information, it is as good as open
DISAGREE = 0.15, np.deg2rad(5)  # [m], [rad] by which surface and landmarks may differ in what they say (guess)
# tracking from one key frame to the next may miss all of the motion, before a wall: a third of what lies between them
TRACKED = 0.05, np.deg2rad(2.5)


def tracked_edge(frames: Sequence[Keyframe], i: int, j: int) -> Edge:
    """As both were tracked."""
    T = inverse(frames[i].T_world_camera) @ frames[j].T_world_camera
    shift, turn = OFF if frames[j].held else TRACKED  # the noise of a frame, where the surface left nothing open
    information = np.diag(np.repeat([turn**-2.0, shift**-2.0], 3))
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
    unit = np.repeat(FIXED[::-1], 3)
    spread = np.linalg.inv(unit[:, None] * edge.information * unit + NONE * np.eye(6)) * np.outer(unit, unit)
    return bool(within_fixed(spread))


def within_fixed(spread: Array) -> Array:
    """Whether covariances (..., 6, 6) of twists [rad], [m] leave no direction open, (...)."""
    unit = np.repeat(FIXED[::-1], 3)
    return np.asarray((np.einsum("...ii->...i", spread) < unit**2).all(axis=-1))


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
