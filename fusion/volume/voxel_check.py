"""For the doctor: does the voxel size that was asked for suit what the frames show?"""

import numpy as np

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.inspect import Check
from fusion.recording.looking.sample import Sample

COARSE = (4, 20)  # voxels across all that is seen: fewer show no shape at all, or hardly one (guess)
FINE = 10  # voxels across one pixel: finer ones hold nothing more, and frames leave holes between them (guess)


def voxel_check(voxel: float | None) -> Check:
    """A check of a sample for a voxel size [m]; None, which is chosen by the program, is always right."""
    return lambda sample: [] if voxel is None else _judge(voxel, sample)


def _judge(voxel: float, sample: Sample) -> list[Finding]:
    extents, pixels = [], []
    camera = sample.recording.camera
    for depth in sample.depths.values():
        known = np.isfinite(depth)
        if known.sum() < 100:
            continue
        points = np.column_stack([sample.rays[known] * depth[known][:, None], depth[known]])
        low, high = np.percentile(points, [5, 95], axis=0)
        extents.append(float((high - low).max()))
        pixels.append(float(np.median(depth[known])) / min(camera.fx, camera.fy))
    if not extents:
        return []
    extent, pixel = float(np.median(extents)), float(np.median(pixels))
    if voxel * COARSE[1] > extent:
        severity = "error" if voxel * COARSE[0] > extent else "warning"
        seen = f"voxels of {1e3 * voxel:g} mm are too coarse: all that a frame shows is {extent:.2g} m wide"
        return [Finding("voxel", severity, seen, f"leave --voxel out, or pass about {pixel:.1g}")]
    if voxel * FINE < pixel:
        seen = f"voxels of {1e3 * voxel:g} mm are too fine: a pixel covers {1e3 * pixel:.2g} mm at this distance"
        return [Finding("voxel", "warning", seen, f"leave --voxel out, or pass about {pixel:.1g}")]
    return []
