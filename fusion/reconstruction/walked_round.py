"""Does the camera go round one thing? Its places say so: it turns as it walks, so that the thing stays in the picture.

Each point that is seen has two spreads of directions: of those from which cameras look at it, and of those in which it
stands in their pictures. Who looks round a room turns on the spot: points move through the picture and are seen from
one side. Who walks along a wall sees both change alike. Who walks round a thing sees it from all sides, at the same
place of the picture: a point at D, where all axes meet at d, moves in the picture by (D - d) / d of the walk's angle.
The spread is the circular variance, 1 - |mean of unit vectors| (Mardia and Jupp 2000, Directional Statistics).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array, inverse, transform
from fusion.volume.subject import MIDDLE, MOSTLY, ROOM, Subject

POINTS = 10_000  # of all views say what all would
VIEWS = 100  # of a recording, spread over it, say what all would: one in 4 deg of a walk round
HELD = (
    0.5  # of its spread round a point, the point's own in the picture: what lies within 0.3 to 1.7 of where axes meet
)
# circular variance of a walk of 28 deg; a hand that sways by 2 cm, half a metre off, has a tenth of it
AROUND = 0.01
MEANT = 0.1  # of the points: a thing that takes a third of the picture's width and height (guess; rooms: none)


@dataclass(frozen=True)
class StandingView:
    """Where a camera stood (4, 4), and the surface it saw."""

    T_world_camera: Array
    surface: PointMap


@dataclass(frozen=True)
class Round:
    """What a camera goes round."""

    subject: Subject  # an object; its size, distance and noise are those of what stays in the picture
    middle: Array  # (3,) of it in the world [m]


def walked_round(views: Sequence[StandingView]) -> Round | None:
    """What the camera goes round and keeps in view; None where there is no such thing, or it is as large as a room."""
    views = views[:: -(-len(views) // VIEWS)] if views else ()
    seen = [seen_by(view, max(1, POINTS // len(views))) for view in views]
    points, depth, sigma = (np.concatenate(part) for part in zip(*seen, strict=True)) if seen else (np.zeros(0),) * 3
    if not len(points):
        return None
    meant = _held(points, views)
    if meant.mean() < MEANT:
        return None
    size = float(np.ptp(np.percentile(points[meant], MIDDLE, axis=0), axis=0).max())
    if size > ROOM:
        return None
    subject = Subject(False, size, float(np.median(depth[meant])), float(np.nanmedian(sigma[meant])), free=False)
    return Round(subject, np.median(points[meant], axis=0))


def _held(points: Array, views: Sequence[StandingView]) -> NDArray[np.bool_]:
    """Points (n, 3) [m] that most pictures show, from several sides, at much the same place of the picture."""
    shown, around, inside = np.zeros(len(points)), np.zeros((len(points), 3)), np.zeros((len(points), 3))
    for view in views:
        here = transform(inverse(view.T_world_camera), points)
        there = _shown(here, view)
        way = here[there] / np.linalg.norm(here[there], axis=1)[:, None]
        shown += there
        inside[there] += way
        around[there] += way @ view.T_world_camera[:3, :3].T
    spread, own = (1 - np.linalg.norm(total, axis=1) / np.maximum(shown, 1) for total in (around, inside))
    return np.asarray((shown >= MOSTLY * len(views)) & (spread > AROUND) & (own < HELD * spread))


def _shown(points: Array, view: StandingView) -> NDArray[np.bool_]:
    """Points (n, 3) of a camera [m] that lie in its picture."""
    camera, before = view.surface.camera, points[:, 2] > 0
    pixels = camera.project(np.where(before[:, None], points, [0.0, 0.0, 1.0]))
    size = np.array([camera.width, camera.height])
    return np.asarray(before & (pixels > -0.5).all(axis=1) & (pixels < size - 0.5).all(axis=1))


def seen_by(view: StandingView, most: int) -> tuple[Array, Array, Array]:
    """Some points of a view in the world (n, 3) [m], their depth (n,) and its noise (n,) [m]."""
    known = np.isfinite(view.surface.normals[..., 0])
    step = max(1, -(-int(known.sum()) // most))
    points = view.surface.points[known][::step].astype(float)
    return transform(view.T_world_camera, points), points[:, 2], view.surface.sigma[known][::step].astype(float)
