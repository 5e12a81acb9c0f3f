"""Frames without the errors of depth that the scan itself shows."""

from dataclasses import replace

import numpy as np

from fusion.turntable.selfcheck import SelfCheck
from fusion.volume.prepared import Prepared


def relieved(frames: list[Prepared | None], check: SelfCheck) -> list[Prepared | None]:
    """The frames with these errors taken out; normals and weights are kept: the change is second order."""
    if not check.wrong_depth:
        return frames
    return [None if frame is None else _relieved(frame, check) for frame in frames]


def _relieved(frame: Prepared, check: SelfCheck) -> Prepared:
    old = frame.surface
    points = check.points(old.points.reshape(-1, 3)).reshape(old.points.shape)
    depth = np.where(np.isfinite(frame.depth), points[..., 2], frame.depth)
    return replace(frame, depth=depth, surface=replace(old, points=points))
