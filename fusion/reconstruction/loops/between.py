"""Frames between key frames, once these stand where they belong: carried along, held against them, or found again."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array, inverse
from fusion.reconstruction.loops.correction import TORN
from fusion.reconstruction.loops.edges import CLOSE, agree, landmark_edge, surface_edge
from fusion.reconstruction.loops.keyframes import Keyframe, keyframe_of
from fusion.tracking.graph import Edge, settle
from fusion.volume.prepared import Prepared

# where a frame is carried to that is not torn: the key frames beside it say the same within these
CARRIED = np.diag(np.repeat([TORN[1] ** -2.0, TORN[0] ** -2.0], 3))


@dataclass(frozen=True)
class Between:
    """Places frames by the key frames beside them."""

    keyframes: Sequence[Keyframe]  # in the order of the recording
    poses: Array  # (k, 4, 4) of them, NaN where they have none
    # off, torn: (n,) frames that were tracked wrongly, and those of which it is a guess where they are
    off: NDArray[np.bool_]
    torn: NDArray[np.bool_]

    def sure(self, index: int) -> bool:
        """A placed frame is where the key frames beside it say."""
        return not self.off[index]

    def place(self, frame: Prepared, T_world_camera: Array) -> Array | None:
        """The pose of a frame (4, 4), from what is known so far (4, 4); None where it is lost (NaN) and stays so."""
        placed, index = bool(np.isfinite(T_world_camera).all()), frame.frame.index
        if placed and not self.off[index]:
            return T_world_camera
        here, carried = keyframe_of(frame, -1, np.eye(4)), T_world_camera if placed else None
        beside = self._beside(index)
        if carried is None or self.torn[index]:  # where it is, only landmarks tell
            found = next((T for k in beside if (T := self._held(k, here, None)) is not None), None)
            if found is not None or carried is None:
                return found
        held = self._held(beside[0], here, carried) if beside else None
        return T_world_camera if held is None else held

    def _held(self, k: int, here: Keyframe, carried: Array | None) -> Array | None:
        """The pose of a frame (4, 4) that suits what it shares with a key frame and where it was carried (4, 4) to.

        Its surface alone slides wherever it leaves a direction open; landmarks and the way it was carried hold it.
        """
        pair = [self.keyframes[k], here]
        marks = landmark_edge(pair, 0, 1, doubtful=True)
        start = None if carried is None else inverse(self.poses[k]) @ carried
        guess = start if marks is None else marks.T_i_j
        surface = None if guess is None else surface_edge(pair, (0, 1), guess, CLOSE, doubtful=False)
        if surface is None:
            return None
        edges = [surface] if marks is None or not agree(marks, surface) else [surface, marks]
        if start is not None:
            edges.append(Edge(0, 1, start, CARRIED, start[:3, 3]))
        return np.asarray(settle(self.poses[k] @ np.stack([np.eye(4), surface.T_i_j]), edges).poses[1])

    def _beside(self, index: int) -> list[int]:
        """The key frames before and after a frame that have a pose, the nearer first."""
        known = [k for k in range(len(self.keyframes)) if np.isfinite(self.poses[k]).all()]
        at = bisect_right([self.keyframes[k].index for k in known], index)
        return sorted(known[max(at - 1, 0) : at + 1], key=lambda k: abs(self.keyframes[k].index - index))
