"""Frames between key frames, once these stand where they belong: carried along, held against them, or found again."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array, inverse
from fusion.reconstruction.loops.edges import CLOSE, SHARE, landmark_edge, surface_edge
from fusion.reconstruction.loops.keyframes import Keyframe, keyframe_of
from fusion.tracking.icp import align_points
from fusion.volume.prepared import Prepared


@dataclass(frozen=True)
class Between:
    """Places frames by the key frames beside them.

    Attributes:
        keyframes: in the order of the recording.
        poses: (k, 4, 4) of them, NaN where they have none.
        off, torn: (n,) frames that were tracked wrongly, and those of which it is a guess where they are.
    """

    keyframes: Sequence[Keyframe]
    poses: Array
    off: NDArray[np.bool_]
    torn: NDArray[np.bool_]

    def sure(self, index: int) -> bool:
        """A placed frame is where the key frames beside it say."""
        return not self.off[index]

    def place(self, frame: Prepared, T_world_camera: Array) -> Array | None:
        """The pose of a frame (4, 4), from what is known so far (4, 4); None where it is lost (NaN) and stays so."""
        placed, index = bool(np.isfinite(T_world_camera).all()), frame.frame.index
        found = self._found(frame) if not placed or self.torn[index] else None
        if not placed or found is not None:
            return found
        return self._held(frame, T_world_camera) if self.off[index] else T_world_camera

    def _held(self, frame: Prepared, T_world_camera: Array) -> Array:
        """The pose of a placed frame (4, 4), or a better one by the surface of the key frame nearest to it."""
        for k in self._beside(frame.frame.index)[:1]:
            here = keyframe_of(frame, -1, T_world_camera)
            guess = inverse(self.poses[k]) @ T_world_camera
            found = align_points(here.points, self.keyframes[k].surface, guess, CLOSE)
            if found.ok and found.inlier_share > SHARE:
                return np.asarray(self.poses[k] @ found.T_model_source)
        return T_world_camera

    def _found(self, frame: Prepared) -> Array | None:
        """The pose of a lost frame (4, 4) by the landmarks that it shares with a key frame beside it."""
        here = keyframe_of(frame, -1, np.eye(4))
        for k in self._beside(frame.frame.index):
            pair = [self.keyframes[k], here]
            marks = landmark_edge(pair, 0, 1, doubtful=True)
            surface = None if marks is None else surface_edge(pair, (0, 1), marks.T_i_j, CLOSE, doubtful=True)
            if surface is not None:
                return np.asarray(self.poses[k] @ surface.T_i_j)
        return None

    def _beside(self, index: int) -> list[int]:
        """The key frames before and after a frame that have a pose, the nearer first."""
        known = [k for k in range(len(self.keyframes)) if np.isfinite(self.poses[k]).all()]
        at = bisect_right([self.keyframes[k].index for k in known], index)
        return sorted(known[max(at - 1, 0) : at + 1], key=lambda k: abs(self.keyframes[k].index - index))
