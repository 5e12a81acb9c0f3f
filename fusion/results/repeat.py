"""The judgement of scans that were repeated, and its numbers in words."""

import numpy as np

from fusion.repeatability.features import ANGLE, RepeatedQuantity
from fusion.repeatability.repeat import Repeat
from fusion.results.judgement import Judgement
from fusion.results.light import Light, level, worst_first

# good up to the first, a problem above the second (guesses)
STANDS_OUT = (2.0, 4.0)  # rms of a scan about the mean, over the median of the others
MISSING = (0.15, 0.5)  # share of the surface that a scan does not show
CLAIM = (1.5, 3.0)  # spread over what the scans' own sigma says


def judge_repeat(found: Repeat) -> Judgement:
    """Whether the scans show one object, whether one stands out, and whether they know how sure they are."""
    rows = found.offsets()
    lost = [row.name for row in rows if row.alignment == "poor"]
    if lost:
        said = f"{', '.join(lost)}: no pose was found in which it fits the others."
        # what else is told of scans that do not lie on each other means nothing
        return Judgement((Light("bad", "One object", said, "Check that all show the same object, whole.", fails=True),))
    lights = []
    rms = np.array([row.rms_m if row.rms_m is not None else np.nan for row in rows], float)
    others = [float(np.nanmedian(np.delete(rms, k))) for k in range(len(rms))]
    ratio = rms / np.maximum(others, 1e-12)
    worst = int(np.nanargmax(ratio)) if np.isfinite(ratio).any() else 0
    if len(rows) > 2:  # of two, both lie as far from their mean
        judged = level(float(ratio[worst]), STANDS_OUT)
        said = f"{rows[worst].name} lies {1e3 * rms[worst]:.2f} mm (rms) off the mean"
        said += f", {ratio[worst]:.1f} times the others."
        do = "Look at its report: a slip, another light, warm-up?" if judged != "ok" else ""
        lights.append(Light(judged, "Scans alike", said, do))
    missing = max(row.missing_share for row in rows)
    judged = level(missing, MISSING)
    said = f"{found.repeatability.shown_by_all:.0%} of the surface is in all scans; the poorest lacks {missing:.0%}."
    lights.append(Light(judged, "Surface in common", said, "Place it alike." if judged != "ok" else ""))
    if found.sigma is not None:
        over = found.repeatability.s / found.sigma
        judged = level(over, CLAIM)
        said = f"They spread by {over:.2f} times the median of the sigma that they carry."
        do = "Something differs from scan to scan that no scan sees in itself." if judged != "ok" else ""
        lights.append(Light(judged, "Own doubt", said, do))
    return Judgement(worst_first(lights))


def repeat_lines(found: Repeat) -> list[str]:
    """For a terminal."""
    within, across = found.repeatability, found.reproducibility
    std = f" +- {1e3 * within.s_std:.3f}" if np.isfinite(within.s_std) else ""
    lines = [
        f"repeatability    s_r {1e3 * within.s:.3f}{std} mm, limit r {2.8e3 * within.s:.3f} mm, "
        f"95 % of the surface below {1e3 * within.p95:.3f} mm",
        "reproducibility  one condition only (--conditions)"
        if across is None
        else f"reproducibility  s_R {1e3 * across.s:.3f} mm, between {across.conditions} conditions s_L "
        f"{1e3 * across.between:.3f} mm, limit R {2.8e3 * across.s:.3f} mm",
    ]
    return lines + [f"{quantity.name:<16} {quantity_words(quantity)}" for quantity in found.features.quantities]


def quantity_words(quantity: RepeatedQuantity) -> str:
    """ "flatness 0.312 mm, std 0.012 mm over 5 scans"."""
    mean, std, unit = scaled(quantity)
    known = int(np.isfinite(quantity.values).sum())
    error = "" if quantity.error is None else f", error {1e3 * quantity.error:+.3f} mm"
    spread = f"std {std:.3f} {unit} over {known} scans" if known > 1 else "in one scan"
    return f"{quantity.term} {mean:.3f} {unit}{error}, {spread}"


def scaled(quantity: RepeatedQuantity) -> tuple[float, float, str]:
    """Mean and standard deviation for a person, with their unit."""
    if quantity.term == ANGLE:
        return float(np.rad2deg(quantity.mean)), float(np.rad2deg(quantity.std)), "deg"
    return 1e3 * quantity.mean, 1e3 * quantity.std, "mm"
