"""What frames say of a finished surface: which parts any of them shows, and which most of them say is not there.

Where frames lie beside each other, a volume grows walls that none saw. And what was there in a few frames only, as a
hand that comes in or an arm, stays in a volume: what is behind is no part of the object and takes no part in it, so
nothing wipes it away. Beside an object whose background is far there is nothing behind either: the projector's shadow
is as wide as the hand. A surface that stood there would be measured, where it is not nearer than anything that is.
"""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.scan.cleaning.facing import facing
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
AROUND = np.ones((5, 5), np.uint8)  # pixels beside which rims lie: a pixel, and what depth and place add (guess)
BESIDE = np.ones((3, 3), np.uint8)  # pixels without depth, where nothing is: single ones lack it by chance
SQUARE = 0.5  # least cosine between normal and line of sight at which a surface is measured, if at all (guess)
ASKED = 36  # frames, evenly from the scan: a part faces a third of them, and more say nothing new


def of_the_object(surface: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float, by_hand: bool) -> Mesh:
    """A surface without what no frame shows where a hand placed them, and without what most look through.

    Args:
        surface: with normals.
        frames, poses, near: as in `looked_through`.
        by_hand: the frames do not lie on each other as on one axis.
    """
    if by_hand:
        surface = vertices_kept(surface, seen_by_any(surface, frames, poses, near))
    passing = looked_through(surface, frames, poses, near)
    # else it is the motion that is wrong, and judged so
    return vertices_kept(surface, ~passing) if 2 * passing.sum() < len(passing) else surface


def seen_by_any(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float) -> NDArray[np.bool_]:
    """(n,) bool: vertices that face the camera of some frame, at the depth that it measured.

    Args:
        mesh: with normals.
        frames: k of them.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
        near: largest difference in depth [m].
    """
    found = np.zeros(len(mesh.vertices), bool)
    for frame, which, (v, u), z, _ in _facing(mesh, frames, poses):
        found[which[np.abs(frame.depth[v, u] - z) < near]] = True  # of NaN it is not true
    return found


def looked_through(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float) -> NDArray[np.bool_]:
    """(n,) bool: vertices that no fewer frames look through, to whatever is behind, than show; and those that a single
    frame shows, where another that faces them has no depth.

    Args:
        mesh: with normals.
        frames: k of them; their points outside the object say what is behind.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
        near: difference in depth [m] up to which a frame shows a vertex, and beyond which it looks through: all around
            too, as at a rim pixels show the object and what is behind it.
    """
    shown, through, blank = np.zeros((3, len(mesh.vertices)), np.int32)
    some = np.unique(np.linspace(0, len(frames) - 1, ASKED).round().astype(int)) if len(frames) else np.zeros(0, int)
    asked = [frames[k] for k in some]
    closest = min((_closest(frame) for frame in asked if frame is not None), default=0.0)
    for frame, which, (v, u), z, cosine in _facing(mesh, asked, poses[some]):
        depth = frame.surface.points[..., 2]
        known = np.isfinite(depth)
        nearest = cv2.erode(np.where(known, depth, np.inf).astype(np.float32), AROUND)
        shown[which[np.abs(depth[v, u] - z) <= near]] += 1
        through[which[known[v, u] & (nearest[v, u] - z > near)]] += 1
        empty = cv2.dilate(known.astype(np.uint8), BESIDE) == 0
        blank[which[empty[v, u] & (cosine > SQUARE) & (z > closest + near)]] += 1
    return np.asarray((through > 0) & (through >= shown) | (blank > 0) & (shown <= 1))


def _closest(frame: Prepared) -> float:
    """The least depth that a frame has [m], inf where it has none."""
    return float(np.min(frame.surface.points[..., 2], initial=np.inf, where=np.isfinite(frame.surface.points[..., 2])))


def _facing(
    mesh: Mesh, frames: Sequence[Prepared | None], poses: Array
) -> Iterator[tuple[Prepared, NDArray[np.intp], tuple[NDArray[np.intp], ...], Array, Array]]:
    """Of each placed frame: the vertices (m,) in its image that face it, their pixels (v, u), their depths (m,) and the
    cosines (m,) between normal and line of sight."""
    assert mesh.normals is not None
    for frame, T in zip(frames, poses, strict=True):
        if frame is not None and np.isfinite(T).all():
            place, z, cosine = (
                of_one[0] for of_one in facing(mesh.vertices, mesh.normals, frame.surface.camera, T[None])
            )
            which = np.flatnonzero(place >= 0)
            yield frame, which, np.unravel_index(place[which], frame.depth.shape), z[which], cosine[which]
