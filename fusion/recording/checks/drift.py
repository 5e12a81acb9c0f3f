"""Does what stands still stay where it is? It creeps while a sensor warms up, and jumps where the camera is moved."""

import numpy as np
from numpy.typing import NDArray

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

Array = NDArray[np.float64]
FEWEST = 6  # frames
STILL = 0.05  # of the depth: what changes by more does not stand still
KNOWN = 0.1  # least share of the image that stands still, to judge by it
LEAST = 0.002  # [m] less harms no scan (guess); a count or two of most files
AT_ONCE = 0.6  # of the whole: one step holds less, else something was moved (guess)
BACK = 1.3  # of the whole: all steps together, as it hardly goes back (guess)
ALIKE = 0.5  # of the whole, at most, by which one half of the pixels differs from the rest (guess)


def check_depth_drifts(sample: Sample) -> list[Finding]:
    """A warning where the depth creeps; for recordings of a camera that stands still."""
    creep = creep_of(sample)
    if creep is None:
        return []
    moved = float(np.nanmedian(creep[-1]))
    way = "farther" if moved > 0 else "nearer"
    seen = f"what stands still came {way} by {abs(moved) * 1e3:.1f} mm little by little"
    do = "the sensor was still warming up: let it run for half an hour, then record again"
    return [Finding("depth", "warning", f"{seen} during the recording", do)]


def creep_of(sample: Sample) -> NDArray[np.float32] | None:
    """(k, h, w) by how much the depth of the sampled frames has crept since the first [m]; None where it does not.

    Time of flight creeps by one length everywhere, triangulation by one disparity: with the square of the depth.
    """
    depths = np.stack([sample.depths[i] for i in sorted(sample.depths)]) if sample.depths else np.zeros((0, 1, 1))
    if len(depths) < FEWEST:
        return None
    first = depths[0].astype(float)
    law = first**2 if sample.recording.camera.principle.triangulates else np.where(np.isfinite(first), 1.0, np.nan)
    still = (np.abs(depths - first) < STILL * first).all(axis=0)
    if still.mean() < KNOWN:
        return None
    change = (depths - first)[:, still] / law[still]
    quarters = np.percentile(change, [25, 50, 75], axis=1)
    middle = (quarters[0] + 2 * quarters[1] + quarters[2]) / 4  # finer than the steps of a median of counts
    whole, steps = abs(middle[-1]), np.abs(np.diff(middle))
    creeps = steps.max() < AT_ONCE * whole and steps.sum() < BACK * whole and whole * np.median(law[still]) > LEAST
    # of three frames at either end, as single pixels are noisy
    each, common = (np.mean(x[-3:], axis=0) - np.mean(x[:3], axis=0) for x in (change, middle))
    if not creeps or np.median(np.abs(each - common)) > ALIKE * whole:
        return None
    return (middle[:, None, None] * law).astype(np.float32)


SIDE = 3  # frames on either side that must agree
STEADY = 0.02  # of the depth: what differs by less from its side's median stands still on that side
ELSEWHERE = 0.007  # of the depth: medians of both sides agree within a count of a Kinect at 2 m (guess)
SHARE = 0.3  # least share of what stands still on both sides that lies elsewhere (guess)


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
