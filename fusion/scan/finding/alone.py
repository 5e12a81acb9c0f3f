"""Frames in which the object alone is left."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.motion import Motion
from fusion.turntable.turning.moving import EDGE
from fusion.turntable.turning.still_background import standing
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared


def masked(frame: Prepared, mask: NDArray[np.bool_]) -> Prepared:
    """The frame with depth and normals within a mask (h, w) alone; its points, which say what is not there, stay."""
    normals = np.where(mask[..., None], frame.surface.normals, np.float32(np.nan))
    depth = np.where(mask, frame.depth, np.float32(np.nan))
    return replace(frame, depth=depth, surface=replace(frame.surface, normals=normals))


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
    return [None if f is None else masked(f, ~(f.surface.points[..., 2] >= wall)) for f in frames]
