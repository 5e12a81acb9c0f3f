"""What the camera, or a program, has done to the depth before it was recorded: seen from its noise and its gaps.

Calibrated on simulated frames of all presets with and without filters, and on real raw recordings (`tests/recording/
test_processed.py`): limits lie where neither gives an alarm.
"""

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Principle
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

FRAMES = 16  # one after the other, whose differences at distances of 1 to 8 frames are compared
LAGS = (1, 2, 6, 8)
SMOOTH = 15  # [px] what the differences of two frames have in common over so many pixels is motion, and no noise
STILL = 0.05  # of the depth: a pixel that spans more has seen two surfaces
FEWEST = 2000  # pixels that show noise alone, or a rim
ALIKE = 0.3  # correlation of neighbours; 0.00 raw, 0.4 to 0.6 behind a filter of 3 x 3 or 5 x 5 pixels
FILLED, JUMP, JUMPS = 0.999, 0.05, 0.002  # valid share inside the image; a rim, of the depth; share of pixels at rims
DO = "record without it where you can: what it smooths or invents is taken for measured"


def check_processed(sample: Sample) -> list[Finding]:
    """Holes that were filled, frames that repeat, smoothing over frames or neighbours; nothing where unseen."""
    frames = _frames(sample)
    new = frames[:1] + [b for a, b in pairwise(frames) if not np.array_equal(a, b, equal_nan=True)]
    principle = sample.recording.camera.principle
    return _filled(sample) + _repeated(len(frames), len(new)) + _smoothed(new, principle)


def _repeated(frames: int, new: int) -> list[Finding]:
    """A camera's noise makes each frame another one."""
    if new == frames:
        return []
    seen = f"{frames - new} of {frames} frames in turn hold exactly the depth of the frame before: repeated"
    do = "record each frame once, as fast as the camera gives them: a copy is no measurement"
    return [Finding("processing", "warning", seen, do)]


def _filled(sample: Sample) -> list[Finding]:
    """Cameras that triangulate see one side of each rim not at all."""
    if not sample.recording.camera.principle.triangulates or not sample.depths:
        return []
    rims = inner = 0
    for depth in sample.depths.values():
        h, w = depth.shape
        inside = depth[h // 10 : h - h // 10, w // 10 : w - w // 10]
        if not inside.size or np.isfinite(inside).mean() < FILLED:
            return []
        rims += int(np.count_nonzero(np.abs(np.diff(inside, axis=1)) > JUMP * inside[:, 1:]))
        inner += inside.size
    if rims < max(JUMPS * inner, FEWEST):
        return []
    seen = "no depth is missing beside any rim, where such a camera sees nothing: holes were filled"
    return [Finding("processing", "warning", seen, DO)]


def _smoothed(frames: list[NDArray[np.float32]], principle: Principle) -> list[Finding]:
    if len(frames) <= max(LAGS):
        return []
    noise = noise_of(frames)
    if noise is None:
        return []
    over_time, neighbours = noise
    findings = []
    one, two, six, eight = over_time
    # an average that forgets makes frames alike, the more the nearer, and no longer after six; motion goes on
    if one < 0.8 * six and one < two < 0.95 * six and abs(eight - six) < 0.04 * six:
        share = f"{100 * one / six:.0f} %"
        seen = f"a frame differs from the next by {share} of what frames far apart differ: smoothed in time"
        findings.append(Finding("processing", "warning", seen, DO))
    # others match windows, whose neighbours share their noise without any filter
    if principle == Principle.TIME_OF_FLIGHT and neighbours > ALIKE:
        seen = f"neighbours share their noise (correlation {neighbours:.2f}): smoothed over pixels, as many drivers do"
        findings.append(Finding("processing", "ok", seen))
    return findings


def noise_of(frames: Sequence[NDArray[np.float32]]) -> tuple[list[float], float] | None:
    """Mean differences at `LAGS` [m], and how alike those of neighbours at lag 1 are; None where too little is still.

    Args:
        frames: depth images (h, w) [m] of frames that follow each other.
    """
    z = np.stack(frames)
    with np.errstate(invalid="ignore"):
        still = np.isfinite(z).all(axis=0) & (np.ptp(z, axis=0) < STILL * z.mean(axis=0))
    inner = cv2.erode(still.astype(np.uint8), np.ones((SMOOTH, SMOOTH), np.uint8)) > 0
    if inner.sum() < FEWEST:
        return None
    z = np.where(still, z, 0).astype(np.float64)
    alone = {lag: [_alone(z[k + lag] - z[k]) for k in range(len(z) - lag)] for lag in LAGS}
    means = [float(np.median(np.mean([np.abs(d[inner]) for d in alone[lag]], axis=0))) for lag in LAGS]
    if not min(means) > 0:
        return None
    both = inner[:, 1:] & inner[:, :-1]
    d = np.stack(alone[1])
    left, right = d[:, :, :-1][:, both], d[:, :, 1:][:, both]
    return means, float(2 * np.mean(left * right) / np.mean(left**2 + right**2))


def _alone(difference: NDArray[np.float64]) -> NDArray[np.float64]:
    return difference - cv2.blur(difference, (SMOOTH, SMOOTH))


def _frames(sample: Sample) -> list[NDArray[np.float32]]:
    recording = sample.recording
    begin = max(0, len(recording) // 2 - FRAMES // 2)
    found = []
    for index in range(begin, min(len(recording), begin + FRAMES)):
        try:
            found.append(recording[index].depth)
        except RecordingError:  # told by the files' check
            return []
    return found
