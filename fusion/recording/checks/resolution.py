"""Has an image enough pixels to track a surface by its shape, and are they side by side?"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.recording.looking.finding import SEVERITIES, Finding
from fusion.recording.looking.sample import Sample

# an object that fills a fifth of the image must show some 150 points away from its rim, by which a turn is found; three
# of four pixels of so small an object are rim
PIXELS = 3000
# pixels in lines of missing ones, one pixel wide, over those with depth: up to 0.002 in recordings of eight cameras,
# 0.21 at most where any share is missing at random, 0.5 where depth was laid point by point on a larger image
THIN = 0.25


def check_resolution(sample: Sample) -> list[Finding]:
    """Sensors of 8 x 8 to about 60 x 45 pixels: they can be looked at and evaluated, but carry no scan."""
    camera = sample.recording.camera
    count = camera.width * camera.height
    size = f"{camera.width} x {camera.height} pixels"
    if count >= PIXELS:
        return [Finding("resolution", "ok", f"{size} can carry a scan")]
    seen = f"{size} are too few to find how a thing turns or a camera moves by the shape that it sees"
    do = f"scan with a sensor of {PIXELS} pixels or more (64 x 48); this one serves fusion evaluate and simulate"
    return [Finding("resolution", "error", seen, do)]


def check_neighbours(sample: Sample) -> list[Finding]:
    """Depth laid point by point on a larger image leaves a grid of holes, and surfaces without normals."""
    if not sample.depths:
        return []
    lines = _thin(sample.recording[min(sample.depths)].depth)  # the kept ones may be coarser
    if lines <= THIN:
        return []
    seen = "a grid of missing pixels runs through all surfaces: depth was laid point by point on a larger image"
    return [
        Finding("neighbours", "error", seen, "record depth in the depth camera's own pixels, not aligned to colour")
    ]


def _thin(depth: NDArray[np.float32]) -> float:
    """Missing pixels (h, w) in lines of one pixel's width, over pixels with depth."""
    there = np.isfinite(depth)
    missing = ~there[1:-1, 1:-1]
    across, along = there[1:-1, :-2].astype(int) + there[1:-1, 2:], there[:-2, 1:-1].astype(int) + there[2:, 1:-1]
    thin = missing & (((across == 2) & (along == 0)) | ((across == 0) & (along == 2)))
    return float(thin.sum() / max(there.sum(), 1))


def note_resolution(sample: Sample) -> list[Finding]:
    """The same where no scan is asked for: such a recording is good for other things."""
    found = check_resolution(sample)
    return [replace(f, severity=min(f.severity, "warning", key=SEVERITIES.index)) for f in found]
