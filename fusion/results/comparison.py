"""The judgement of a comparison with a reference, and how its numbers are read."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fusion.results.judgement import Judgement
from fusion.results.light import LEVELS, Light, level, worst_first

# good up to the first, a problem above the second (guesses); lengths are absolute: what depth cameras reach where an
# object fills the image (docs/first_scan.md), and a larger one need not be less right
RMS_M = (0.002, 0.005)
FAR_SHARE = (0.1, 0.5)  # of the mesh, farther than 2 mm from the reference
BIAS_M = (0.001, 0.003)
LEFT_OUT_SHARE = (0.5, 0.9)  # of the mesh, by --max-distance: a table around an object may be half of it
MISSING_SHARE = (0.1, 0.3)
UNSEEN_SHARE = (0.5, 0.9)  # of the reference, which counts as never seen: from one side a half may be
SCALE = (0.002, 0.01)
KNOWABLE = (0.05, 0.5)  # of the vertices, beyond three sigma: 0.3 % of normal errors are


def judge_comparison(comparison: Any) -> Judgement:
    """Accuracy, bias, completeness and scale; where no pose fits, that alone: distances mean nothing then.

    Args:
        comparison: the fields of `comparison.json`, as a mapping or as attributes.
    """
    alignment = field_of(comparison, "alignment")
    if getattr(alignment, "status", alignment) == "poor":
        said = "The mesh fits the reference in no pose: the distances mean nothing."
        return Judgement((Light("bad", "Alignment", said, "Check that both show one object in one unit.", fails=True),))
    near, far = (field_of(comparison, name) or {} for name in ("accuracy", "completeness"))
    lights = [_accuracy(near), _bias(near, kept=field_of(comparison, "scale_interval") is None)] if near else []
    if field_of(comparison, "left_out_share"):
        lights.append(_left_out(number_of(comparison, "left_out_share")))
    if far:
        share = share_within(far, 0.005)
        unseen = field_of(comparison, "unseen_share") or 0.0
        judged = max(level(1 - share, MISSING_SHARE), level(unseen, UNSEEN_SHARE), key=LEVELS.index)
        do = "Scan what is missing, or pass --seen with the points that the scan could see." if judged != "ok" else ""
        seen = f" that may have been seen ({1 - unseen:.0%} of it)" if unseen > 0 else ""
        reason = f"{share:.1%} of the reference's surface{seen} has mesh within 5 mm."
        lights.append(Light(judged, "Completeness", reason, do))
    known = field_of(comparison, "knowable") or field_of(comparison, "sigma")
    if known is not None:
        lights.append(_knowable(number_of(known, "beyond_3_sigma")))
    if field_of(comparison, "scale_interval") is not None:
        lights.append(_scale(comparison))
    return Judgement(worst_first(lights))


def _accuracy(near: Any) -> Light:
    rms, beyond = number_of(near, "rms"), 1 - share_within(near, 0.002)
    far = "ok" if np.isnan(beyond) else level(beyond, FAR_SHARE)
    judged = max(level(rms, RMS_M), far, key=LEVELS.index)
    said = f"The mesh stands {millimetres(rms)} (rms) off the reference"
    said += "" if np.isnan(beyond) else f", {beyond:.0%} of it more than 2 mm"
    do = "Look where in the picture of the distances: an edge, one side, or all over?" if judged != "ok" else ""
    return Light(judged, "Accuracy", said + ".", do)


def _left_out(share: float) -> Light:
    judged = level(share, LEFT_OUT_SHARE)
    said = f"{share:.1%} of the mesh lies beyond the largest distance: accuracy and bias are of the rest alone."
    return Light(judged, "Left out", said, "Give a larger --max-distance." if judged != "ok" else "")


def _bias(near: Any, kept: bool) -> Light:
    bias = number_of(near, "mean_signed")
    judged = level(abs(bias), BIAS_M)
    do = ""
    if judged != "ok" and level(1 - share_within(near, 0.005), FAR_SHARE) != "ok":
        do = "Leave out what is no part of the reference (a table, another thing, spikes) with --max-distance."
    elif judged != "ok":
        do = "Calibrate the depth (fusion calibrate depth)" + (", or compare with --scale." if kept else ".")
    side = "outside" if bias > 0 else "inside"
    return Light(judged, "Bias", f"On average it lies {millimetres(abs(bias))} {side} the reference.", do)


def _knowable(beyond: float) -> Light:
    judged = level(beyond, KNOWABLE)
    said = f"{beyond:.1%} of the mesh's vertices lie off by more than three times what the scan itself can be wrong by."
    do = "There scan and reference differ: see where in the picture of deviations over sigma." if judged != "ok" else ""
    return Light(judged, "Beyond the scan's doubt", said, do)


def _scale(comparison: Any) -> Light:
    scale, interval = float(field_of(comparison, "scale")), field_of(comparison, "scale_interval")
    known = None not in interval and np.isfinite(interval).all()
    if not known and scale != 1:
        said = f"The best scale lies {'below' if scale < 1 else 'above'} {scale:.4g}, the end of what is looked for."
        do = "Check that both show one object in one unit; a mesh that is so far off multiply before it is compared."
        return Light("bad", "Scale", said, do)
    if not known:
        said = "What was scanned does not tell the scale (a plane does not): it was kept."
        return Light("warning", "Scale", said, "Scan more of the object's sides.")
    said = f"The mesh fits best when multiplied by {scale:.5f} (95 %: {interval[0]:.5f} to {interval[1]:.5f})."
    judged = "ok" if interval[0] <= 1 <= interval[1] else level(abs(scale - 1), SCALE)
    do = "Check the focal length, the unit and the scale of the depth." if judged != "ok" else ""
    return Light(judged, "Scale", said, do)


def field_of(source: Any, name: str) -> Any:
    """An entry of a mapping, or an attribute; None where there is none."""
    return source.get(name) if isinstance(source, Mapping) else getattr(source, name, None)


def number_of(block: Any, name: str) -> float:
    """A number of a block, NaN where it is not known."""
    value = field_of(block, name)
    return float("nan") if value is None else float(value)


def share_within(block: Any, limit: float) -> float:
    """Share within a limit [m], NaN where it is not known; keys are numbers or texts."""
    found = [share for key, share in (field_of(block, "within") or {}).items() if abs(float(key) - limit) < 1e-9]
    return float("nan") if not found or found[0] is None else float(found[0])


def millimetres(value: float) -> str:
    """ "1.23 mm"."""
    return f"{value * 1000:.2f} mm" if np.isfinite(value) else "unknown mm"
