"""Stretches: frames of a recording that are one measurement, as they are close in time and from one pose."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import DETECTED
from fusion.discrepancy.observe.stage import KnownScene
from fusion.errors import RecordingError
from fusion.recording.recording import Recording

TOGETHER_S = 10.0  # frames within this time are one stretch, unless they themselves show that they move
MOST_BLOCKS = 20  # a longer series is grouped
FLOOR_M = 2e-5  # a hundredth of usual noise (guess): where counts never change, rounding does
EVERY = 4  # of the rows and columns: a mean over an image needs no more


class Stretches(NamedTuple):
    """Indices of the frames of each, and whether they are short because frames move."""

    frames: list[tuple[int, ...]]
    moving: bool


def stretches_of(stage: KnownScene) -> Stretches:
    """The frames that belong together. RecordingError when no frame is at the time of a pose."""
    recording, poses = stage.recording, stage.recording.poses
    assert poses is not None
    found = _stretches(stage, TOGETHER_S)
    if not found:
        raise RecordingError(
            "no frame is at the time of a pose",
            recording.path,
            f"frames {_span(recording.timestamps)}, poses {_span(poses.timestamps[poses.valid])}",
            "poses at the times of the frames",
            "check the time stamps in depth.txt and groundtruth.txt",
        )
    if not moves(recording, found):
        return Stretches(found, moving=False)
    return Stretches(_stretches(stage, float(np.ptp(recording.timestamps)) / (MOST_BLOCKS - 1)), moving=True)


def moves(recording: Recording, stretches: Sequence[Sequence[int]]) -> bool:
    """True when the frames of stretches follow each other more closely than noise: what moves them is slower.

    Of independent numbers the squares of steps are twice those about the mean (von Neumann, The Annals of Mathematical
    Statistics 12, 1941).
    """
    steps = squares = 0.0
    count = 0
    for stretch in stretches:
        if len(stretch) > 2:
            images = [np.asarray(recording[i].depth, float)[::EVERY, ::EVERY] for i in stretch]
            seen = np.isfinite(images).all(axis=0)
            course = np.array([image[seen].mean() for image in images]) if seen.any() else np.zeros(len(images))
            steps += float((np.diff(course) ** 2).sum()) / 2
            squares += float(((course - course.mean()) ** 2).sum())
            count += len(stretch)
    shown = squares > count * FLOOR_M**2  # less no tile shows
    return bool(shown and (1.0 - steps / squares) * np.sqrt(count) > DETECTED)


def _stretches(stage: KnownScene, together_s: float) -> list[tuple[int, ...]]:
    recording, poses = stage.recording, stage.recording.poses
    assert poses is not None
    match = stage.simulated[0] if stage.simulated else None
    at_frames = poses.at(recording.timestamps)
    blocks: list[list[int]] = []
    for i, stamp in enumerate(recording.timestamps):
        if not at_frames.valid[i] or (match and match.partner[i] < 0):
            continue
        last = blocks[-1] if blocks else None
        if (
            last
            and stamp - recording.timestamps[last[0]] < together_s
            and np.allclose(at_frames.poses[i], at_frames.poses[last[0]], atol=1e-9)
            and (match is None or match.same(last[0], i))
        ):
            last.append(i)
        else:
            blocks.append([i])
    size = -(-len(blocks) // MOST_BLOCKS)
    same = match is None and all(
        np.allclose(at_frames.poses[b[0]], at_frames.poses[blocks[0][0]], atol=1e-9) for b in blocks
    )
    if size > 1 and same:
        blocks = [[i for block in blocks[k : k + size] for i in block] for k in range(0, len(blocks), size)]
    return [tuple(block) for block in blocks]


def _span(stamps: NDArray[np.float64]) -> str:
    return f"from {stamps.min():.10g} to {stamps.max():.10g} s"
