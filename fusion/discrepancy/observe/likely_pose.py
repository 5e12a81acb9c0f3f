"""Likely poses: where the recordings say that the camera stood, so that errors of poses are small about there.

Depth is not linear in a pose: 6 mm and 6 mrad change a wall at 2 m by up to a millimetre beyond the first order, which
looks like an error of the sensor once the first order is taken out.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import NOTICED
from fusion.discrepancy.inference.tile_covariance import TileCovariance, pose_columns
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations

Vector = NDArray[np.float64]

ROUNDS = 3  # each leaves the product of what is left of the error and the error: after two it is a thousandth


def at_likely_poses(
    blocks: Sequence[FrameBlock], observations: Observations, covariance: TileCovariance
) -> list[FrameBlock]:
    """The blocks with the errors of their poses that are likeliest when nothing is missing; as they are where that
    makes no difference."""
    before = after = covariance.whiten(observations.residual)
    moved, columns = list(blocks), np.stack(pose_columns(observations))
    for _ in range(ROUNDS):
        errors = _by_recording(observations, columns @ covariance.pulled(after))
        moved = [
            replace(k, moved=errors[k.place], held=k.held and replace(k.held, moved=errors[k.place])) for k in blocks
        ]
        after = covariance.whiten(observations.seen_again(moved).residual)
    return moved if before @ before - after @ after > NOTICED else list(blocks)


def _by_recording(observations: Observations, weights: Vector) -> defaultdict[int, tuple[float, ...]]:
    """By recording, the motion (6,) of the scene in the camera frame [rad, m], from its sizes along all columns (6 g,)
    in standard deviations; nothing of a recording without tiles."""
    stages = {patch.block.place: patch.block.stage for patch in observations.patches}
    out: defaultdict[int, tuple[float, ...]] = defaultdict(tuple)
    for place, own in zip(np.unique(observations.place).tolist(), weights.reshape(-1, 6), strict=True):
        out[place] = tuple((own * np.repeat([stages[place].sigma_rad, stages[place].sigma_m], 3)).tolist())
    return out
