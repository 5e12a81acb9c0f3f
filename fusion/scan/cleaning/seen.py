"""What frames say of a finished surface: which parts any of them shows, and which most of them look through.

Where frames lie beside each other, a volume grows walls that none saw. And what was there in a few frames only, as a
hand that comes in or an arm, stays in a volume: what is behind is no part of the object and takes no part in it, so
nothing wipes it away.
"""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.scan.cleaning.facing import facing
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
AROUND = np.ones((5, 5), np.uint8)  # pixels beside which rims lie: a pixel, and what depth and place add (guess)
ASKED = 36  # frames, evenly from the scan: a part faces a third of them, and more say nothing new


def seen_by_any(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float) -> NDArray[np.bool_]:
    """(n,) bool: vertices that face the camera of some frame, at the depth that it measured.

    Args:
        mesh: with normals.
        frames: k of them.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
        near: largest difference in depth [m].
    """
    found = np.zeros(len(mesh.vertices), bool)
    for frame, which, (v, u), z in _facing(mesh, frames, poses):
        found[which[np.abs(frame.depth[v, u] - z) < near]] = True  # of NaN it is not true
    return found


def looked_through(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float) -> NDArray[np.bool_]:
    """(n,) bool: vertices that no fewer frames look through, to whatever is behind, than show.

    Args:
        mesh: with normals.
        frames: k of them; their points outside the object say what is behind.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
        near: difference in depth [m] up to which a frame shows a vertex, and beyond which it looks through: all around
            too, as at a rim pixels show the object and what is behind it.
    """
    shown, through = np.zeros((2, len(mesh.vertices)), np.int32)
    some = np.unique(np.linspace(0, len(frames) - 1, ASKED).round().astype(int)) if len(frames) else np.zeros(0, int)
    for frame, which, (v, u), z in _facing(mesh, [frames[k] for k in some], poses[some]):
        depth = frame.surface.points[..., 2]
        nearest = cv2.erode(np.where(np.isfinite(depth), depth, np.inf).astype(np.float32), AROUND)
        shown[which[np.abs(depth[v, u] - z) <= near]] += 1
        through[which[np.isfinite(depth[v, u]) & (nearest[v, u] - z > near)]] += 1
    return np.asarray((through > 0) & (through >= shown))


def _facing(
    mesh: Mesh, frames: Sequence[Prepared | None], poses: Array
) -> Iterator[tuple[Prepared, NDArray[np.intp], tuple[NDArray[np.intp], ...], Array]]:
    """Of each placed frame: the vertices (m,) in its image that face it, their pixels (v, u) and their depths (m,)."""
    assert mesh.normals is not None
    for frame, T in zip(frames, poses, strict=True):
        if frame is not None and np.isfinite(T).all():
            place, z, _ = (of_one[0] for of_one in facing(mesh.vertices, mesh.normals, frame.surface.camera, T[None]))
            which = np.flatnonzero(place >= 0)
            yield frame, which, np.unravel_index(place[which], frame.depth.shape), z[which]
