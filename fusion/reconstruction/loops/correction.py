"""From the corrected poses of key frames to those of all frames."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.geometry.pose import Array, angle, inverse, pose, rotation
from fusion.reconstruction.loops.keyframes import Keyframe

# where the key frames before and after carry a frame to places farther apart [m], [rad], tracking between them was
# wrong, and the frame is taken to lie on the way between the two (guess); absolute, of a hand, as what follows
TORN = 0.05, np.deg2rad(2)
# farther than this it is more than the noise of a frame, and the frame is held against the nearer key frame (guess)
OFF = 0.01, np.deg2rad(0.5)


@dataclass(frozen=True)
class CorrectedPoses:
    """Poses of all frames."""

    poses: Array  # (n, 4, 4), NaN where lost
    off: NDArray[np.bool_]  # (n,) key frames contradict how these were tracked
    torn: NDArray[np.bool_]  # (n,) so much that where they are is a guess


def corrected(
    poses: Array, pieces: NDArray[np.int64], stamps: NDArray[np.float64], frames: Sequence[Keyframe], settled: Array
) -> CorrectedPoses:
    """Poses of all frames, each carried by the key frames of its piece before and after it.

    Args:
        poses: (n, 4, 4) as tracked, NaN where lost.
        pieces: (n,) of the trajectory.
        stamps: (n,) time [s].
        settled: (k, 4, 4) their new poses, NaN where they have none.
    """
    out = np.full_like(poses, np.nan)
    off, torn = np.zeros((2, len(poses)), bool)
    moved = settled @ inverse(np.stack([frame.T_world_camera for frame in frames]))
    known = np.isfinite(moved).all(axis=(1, 2))
    index, piece = (np.array([getattr(frame, name) for frame in frames]) for name in ("index", "piece"))
    for number in np.unique(piece[known]):
        own = np.flatnonzero(known & (piece == number))
        for i in np.flatnonzero((pieces == number) & np.isfinite(poses).all(axis=(1, 2))):
            at = int(np.searchsorted(index[own], i, side="right"))
            a, b = own[max(at - 1, 0)], own[min(at, len(own) - 1)]
            start, end = stamps[index[a]], stamps[index[b]]
            share = float(np.clip((stamps[i] - start) / (end - start), 0, 1)) if end > start else 0.0
            before, after = moved[a] @ poses[i], moved[b] @ poses[i]
            apart = inverse(before) @ after
            shift, turn = np.linalg.norm(apart[:3, 3]), angle(apart)
            off[i], torn[i] = (shift > limit[0] or turn > limit[1] for limit in (OFF, TORN))
            if at == len(own) and i:  # after the last key frame nothing contradicts: as before it
                off[i], torn[i] = off[i - 1], torn[i - 1]
            out[i] = _between(settled[a], settled[b], share) if torn[i] else _between(before, after, share)
    return CorrectedPoses(out, off, torn)


def _between(a: Array, b: Array, share: float) -> Array:
    """The pose (4, 4) at a share of the way from one to another."""
    step = inverse(a) @ b
    turn = rotation(share * Rotation.from_matrix(step[:3, :3]).as_rotvec())
    return np.asarray(a @ pose(turn, share * step[:3, 3]))
