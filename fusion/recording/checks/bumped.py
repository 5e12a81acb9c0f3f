"""Was a camera that should stand still moved? What stands still then lies elsewhere before and after."""

import numpy as np
from numpy.typing import NDArray

from fusion.recording.checks.drift import creep_of
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

SIDE = 3  # frames on either side that must agree
STEADY = 0.02  # of the depth: what differs by less from its side's median stands still on that side
ELSEWHERE = 0.007  # of the depth: medians of both sides agree within a count of a Kinect at 2 m (guess)
SHARE = 0.3  # least share of what stands still on both sides that lies elsewhere (guess)
KNOWN = 0.1  # least share of the image that stands still, to judge by it


def check_camera_bumped(sample: Sample) -> list[Finding]:
    """An error where what stands still lies in one place in all frames before, and in another in all after."""
    indices = sorted(sample.depths)
    if len(indices) < 2 * SIDE:
        return []
    depths = np.stack([sample.depths[i] for i in indices])
    creep = creep_of(sample)
    depths = depths if creep is None else depths - creep  # a sensor that warms up was not moved
    shares = {k: _elsewhere(depths[:k], depths[k:]) for k in range(SIDE, len(indices) - SIDE + 1)}
    at = max(shares, key=lambda k: shares[k])
    if shares[at] < SHARE:
        return []
    seen = f"the camera was moved between frames {indices[at - 1]} and {indices[at]}"
    seen += f": {100 * shares[at]:.0f} % of what stands still lie elsewhere from then on"
    return [Finding("motion", "error", seen, "record again with a firm camera, or give only the frames on one side")]


def _elsewhere(before: NDArray[np.float32], after: NDArray[np.float32]) -> float:
    """Share of the pixels that stand still in both stacks (k, h, w) whose depth is not the same in both."""
    (first, still_first), (second, still_second) = _still(before), _still(after)
    still = still_first & still_second
    if still.mean() < KNOWN:
        return 0.0
    return float((np.abs(second - first)[still] > ELSEWHERE * first[still]).mean())


def _still(depths: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Median (h, w) of a stack [m], and where all values are known and near it."""
    known = np.isfinite(depths).all(axis=0)
    middle = np.median(np.where(known, depths, np.float32(0)), axis=0)
    return middle, known & (np.abs(depths - middle) < STEADY * middle).all(axis=0)
