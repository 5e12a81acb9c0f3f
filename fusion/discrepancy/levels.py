"""Levels: depths of a file of counts as the steps of the sensor's own rounding that these counts stand for.

A Kinect v1 rounds disparities, and its files round the depths of those once more, to millimetres. That moves all depths
of a step by the same part of a millimetre, which no noise smooths and no number of pixels averages out.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.unrounded import STEP, rounding_of
from fusion.recording.recording import Frame, Recording
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

Depth = NDArray[np.float64]

NEAREST = 0.501  # of a count: as far as a count lies from what it stands for
STRAY = 1e-3  # of the values, which a filter or a lossy file may have left elsewhere
CHANCE = 0.9  # share of any values that are so near to a step: with more, that they are says nothing


def at_levels(recordings: Sequence[Recording], sensor: Sensor) -> Sequence[Recording]:
    """The recordings with depths at the steps of a model's rounding; as they are where their counts are not its steps.

    Where steps are closer than counts, depths stay.
    """
    rounding = rounding_of(sensor)
    if rounding is None or not all(recording.in_counts for recording in recordings):
        return recordings
    of_counts: dict[str, Any] = {rounding.lattice["constant"]: 0.0}  # the file's counts are such steps themselves
    rounding = replace(rounding, **of_counts)
    views = [View(recording.camera, baseline=sensor.baseline) for recording in recordings]
    near, usual, known = np.sum(
        [_agreement(one, rounding, view) for one, view in zip(recordings, views, strict=True)], axis=0
    )
    if near < (1.0 - STRAY) * known or usual > CHANCE * known or not known:
        return recordings
    return [_levelled(one, rounding, view) for one, view in zip(recordings, views, strict=True)]


def _agreement(recording: Recording, rounding: Effect, view: View) -> tuple[float, float, float]:
    """Pixels of the first frame that are near to a step, that would be by chance, and that could tell."""
    depth = np.asarray(recording[0].depth, float)
    level, apart = _level(depth, rounding, view)
    count = 1.0 / recording.camera.depth_scale
    tells = apart > count
    near = np.abs(level - depth) <= NEAREST * count
    return float(np.sum(near & tells)), float(np.sum(count / apart[tells])), float(np.sum(tells))


def _level(depth: Depth, rounding: Effect, view: View) -> tuple[Depth, Depth]:
    """Nearest step (h, w) [m] of each depth (h, w) [m], and how far steps lie apart there [m]; NaN where missing."""
    with np.errstate(all="ignore"):
        return depth + rounding.bias(depth, view), np.broadcast_to(STEP * rounding.noise(depth, view), depth.shape)


def _levelled(recording: Recording, rounding: Effect, view: View) -> Recording:
    count = 1.0 / recording.camera.depth_scale

    def load(index: int) -> Frame:
        frame = recording[index]
        depth = np.asarray(frame.depth, float)
        level, apart = _level(depth, rounding, view)
        return replace(frame, depth=np.where(apart > count, level, depth).astype(np.float32))

    return replace(recording, load=load)
