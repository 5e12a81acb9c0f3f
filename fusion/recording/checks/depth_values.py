"""Are the depth values in the right unit, and is missing depth marked as such?"""

import math

import numpy as np

from fusion.geometry.camera import Principle
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

# [m] where the median of an indoor depth image lies
PLAUSIBLE = (0.15, 12.0)
# and where it most likely lies, to choose between scales
LIKELY = (0.3, 6.0)
# [m] nearer no camera of its kind measures (Kinect v1 0.4, TrueDepth 0.15; Azure Kinect 0.25, Kinect v2 0.5, telephones
# 0.1), and farther hardly one does (Kinects 8): makers' data, from memory
MEASURABLE = {Principle.STRUCTURED_LIGHT: (0.14, 8.0), Principle.TIME_OF_FLIGHT: (0.1, 8.0)}
CODES = 3  # for missing: SoftKinetic's cameras write 32001 where they see too little, 32002 where too much
HOW = "a camera.json, or fx,fy,cx,cy,SCALE"
# counts per metre in use: Kinect mm, TUM, YCB-Video, Redwood and RealSense variants, centimetres
SCALES = (1000.0, 5000.0, 10000.0, 4000.0, 8000.0, 100.0)


def check_depth_values(sample: Sample) -> list[Finding]:
    """No depth at all, another code for missing, a wrong depth scale."""
    if not len(sample.medians):
        return []
    if not np.isfinite(sample.medians).any():
        return [Finding("depth", "error", "no valid depth in any sampled frame", "look at the depth images")]
    return _codes(sample) + _scale(sample)


def implausible(median: float) -> str:
    """What is to be said of a median depth [m] that no room holds; empty where it is usual."""
    if not np.isfinite(median) or PLAUSIBLE[0] <= median <= PLAUSIBLE[1]:
        return ""
    return f"depths of about {median:.3g} m: is depth_scale in camera.json right? `fusion info` says what fits"


def shares(sample: Sample) -> dict[str, float]:
    """Share of pixels that are 0, 65535 and valid in the sampled frames; empty when frames are no files."""
    total = sample.counts.sum()
    if not total:
        return {}
    zero, full = sample.counts[0] / total, sample.counts[INVALID_COUNT] / total
    return {"zero_share": float(zero), "65535_share": float(full), "valid_share": float(1 - zero - full)}


def range_m(sample: Sample) -> tuple[float, float] | None:
    """1st and 99th percentile of the depth [m] over the kept frames."""
    if not sample.depths:
        return None
    depth = np.concatenate([image[np.isfinite(image)] for image in sample.depths.values()])
    return (float(np.percentile(depth, 1)), float(np.percentile(depth, 99))) if depth.size else None


def _codes(sample: Sample) -> list[Finding]:
    share = shares(sample)
    findings = []
    if share and share["valid_share"] < 0.02:
        seen = f"only {100 * share['valid_share']:.1f} % of the pixels hold depth"
        findings.append(Finding("depth", "warning", seen, "look at the depth images"))
    if share and share["65535_share"] > 0:
        seen = f"65535 in {100 * share['65535_share']:.1f} % of the pixels: read as missing"
        findings.append(Finding("depth", "ok", seen))
    return findings + _other_code(sample)


def _other_code(sample: Sample) -> list[Finding]:
    """A few largest counts that many pixels have, far above all others: other codes for missing."""
    known = sample.counts.copy()
    known[[0, INVALID_COUNT]] = 0
    used = np.flatnonzero(known)
    if len(used) < 10 or sample.recording.files is None or sample.recording.files.to_metres is not None:
        return []
    alone = np.flatnonzero(used[-CODES:] > 1.2 * used[-CODES - 1 : -1])  # they do not stand behind all else
    if not len(alone):
        return []
    codes = used[-CODES:][alone[0] :]
    share = known[codes].sum() / sample.counts.sum()
    if share < 0.01:  # a real surface spreads over many counts
        return []
    told = " and ".join(map(str, codes))
    seen = f"count {told} in {100 * share:.1f} % of the pixels, all others below {used[-len(codes) - 1] + 1}"
    return [Finding("depth", "warning", seen, "write 0 there if it stands for missing depth")]


def _scale(sample: Sample) -> list[Finding]:
    camera = sample.recording.camera
    median = float(np.nanmedian(sample.medians))
    if sample.recording.files is not None and sample.recording.files.to_metres is not None:
        return [Finding("depth", "ok", f"median depth {median:.3g} m")]
    step = _common_step(sample)
    # millimetres written as 5000 or 10000 counts a metre leave only every 5th or 10th count
    if step in (5, 10) and camera.depth_scale == 1000:
        seen = f"all counts are multiples of {step} while depth_scale is 1000 (median {median:.3g} m)"
        do = f"if these are millimetres times {step}, pass --camera with depth_scale {1000 * step}"
        severity = "warning" if PLAUSIBLE[0] <= median <= PLAUSIBLE[1] else "error"
        return [Finding("depth", severity, seen, do)]
    low, high = MEASURABLE.get(camera.principle, (0.0, PLAUSIBLE[1]))
    nearest = range_m(sample)
    counts = median * camera.depth_scale
    fitting = " or ".join(f"{s:g} ({counts / s:.3g} m)" for s in SCALES if LIKELY[0] <= counts / s <= LIKELY[1])
    too_near = nearest is not None and nearest[0] < low
    if too_near or not PLAUSIBLE[0] <= median <= min(high, PLAUSIBLE[1]):
        if not sample.recording.in_counts:
            seen = f"median depth {median:.3g} m, as real numbers are metres: not what such cameras measure"
            return [Finding("depth", "error", seen, "write metres, or whole mm (16-bit PNG, depth_scale 1000)")]
        seen = f"median depth {median:.3g} m with depth_scale {camera.depth_scale:g}: not plausible indoors"
        if median >= PLAUSIBLE[0] and too_near and nearest is not None:
            near = f"depth from {nearest[0]:.2g} m on with depth_scale {camera.depth_scale:g}"
            seen = f"{near}: nearer than such cameras measure"
        do = f"pass --camera with depth_scale {fitting or 'as it is right'}: {HOW}"
        return [Finding("depth", "error", seen, do)]
    seen = f"median depth {median:.3g} m"
    if median > LIKELY[1] and fitting and sample.recording.in_counts:
        do = f"if that is no hall, pass --camera with depth_scale {fitting}: {HOW}"
        return [Finding("depth", "warning", f"{seen} with depth_scale {camera.depth_scale:g}: far for a room", do)]
    return [Finding("depth", "ok", f"{seen}, a plausible unit")]


def _common_step(sample: Sample) -> int:
    """Greatest common divisor of all counts that occur."""
    used = np.flatnonzero(sample.counts)
    used = used[(used > 0) & (used < INVALID_COUNT)]
    return math.gcd(*used.tolist()) if len(used) > 20 else 1
