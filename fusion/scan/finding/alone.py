"""Frames in which the object alone is left."""

import numpy as np

from fusion.turntable.motion import Motion
from fusion.turntable.turning.moving import EDGE
from fusion.turntable.turning.still_background import standing
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared


def object_alone(frames: list[Prepared | None], region: Region, motion: Motion) -> list[Prepared | None]:
    """The frames without what stands behind the object and does not turn with it: that is neither tracked nor fused.

    Args:
        frames: cut to the window of the region.
        region: its images cut to the same window.
        motion: of what turns.
    """
    shown = next((f for f in frames if f is not None), None)
    if shown is None or region.wall is None:
        return frames
    away = standing(region.wall, shown.surface.camera, motion.axis, motion.radius + EDGE)
    if not away.any():
        return frames
    wall = np.where(away, region.wall, np.float32(np.inf))
    return [None if f is None else f.masked(~(f.surface.points[..., 2] >= wall)) for f in frames]
