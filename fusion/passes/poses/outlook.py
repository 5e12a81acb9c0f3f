"""Where the frames of a pass looked through: no surface of the object can be there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
ASKED = 24  # frames, evenly from the pass: of a whole turn one every 15 degrees
FACING = 0.3  # least cosine between a surface's normal and the line of sight: flatter ones say little (guess)
SURE = 2  # frames that look through a place: one alone may be a wrong pixel


@dataclass(frozen=True)
class Outlook:
    """Some frames of a pass."""

    cameras: list[Camera]  # of each, cut to the object's window
    T_camera_object: Array  # (k, 4, 4)
    depth: list[NDArray[np.float32]]  # of each, (h, w) [m] of all that it measured, NaN where that is nothing
    margin: float  # [m] behind a place from which on what is measured says that nothing is there

    @staticmethod
    def of(frames: Sequence[Prepared | None], poses: Array, margin: float) -> "Outlook":
        """Of frames with poses (n, 4, 4) `T_object_camera`."""
        placed = [i for i, f in enumerate(frames) if f is not None and np.isfinite(poses[i]).all()]
        some = np.array(placed)[np.unique(np.linspace(0, len(placed) - 1, ASKED).round().astype(int))] if placed else []
        shown = [frame for i in some if (frame := frames[i]) is not None]
        return Outlook(
            [f.surface.camera for f in shown],
            np.array([pose.inverse(poses[i]) for i in some]).reshape(-1, 4, 4),
            [np.asarray(f.surface.points[..., 2], np.float32) for f in shown],
            margin,
        )

    def through(self, points: Array, normals: Array | None = None) -> NDArray[np.bool_]:
        """(n,) bool: places that more frames look through than show something at, and at least `SURE` of them.

        Args:
            points: (n, 3) in the pass's object frame [m].
            normals: (n, 3) outwards; frames that such a surface does not face are not asked. None asks all.
        """
        beyond, shown = np.zeros((2, len(points)), np.int32)
        for camera, T, depth in zip(self.cameras, self.T_camera_object, self.depth, strict=True):
            local = pose.transform(T, points)
            z = local[:, 2]
            asked = z > 0.05
            if normals is not None:
                towards = -np.einsum("ij,ij->i", normals @ T[:3, :3].T, local)
                asked &= towards > FACING * np.linalg.norm(local, axis=1)
            which = np.flatnonzero(asked)
            u, v = np.rint(np.clip(camera.project(local[which]), -9, 99999)).astype(int).T
            inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
            which = which[inside]
            off = depth[v[inside], u[inside]] - z[which]
            beyond[which[off > self.margin]] += 1  # of NaN it is not true
            shown[which[np.abs(off) <= self.margin]] += 1
        return np.asarray((beyond >= SURE) & (beyond > shown))
