"""The judgement of scans that were repeated, and its numbers in words."""

import numpy as np

from fusion.repeatability.alike import OTHER, AgainstOthers, difference
from fusion.repeatability.features import ANGLE, RepeatedQuantity
from fusion.repeatability.repeat import Repeat
from fusion.results.judgement import Judgement
from fusion.results.light import Light, level, worst_first

# good up to the first, a problem above the second (guesses)
STANDS_OUT = (2.0, 4.0)  # rms of a scan to the others, over what these are apart
OF_SIZE = (OTHER, 2 * OTHER)  # rms of two scans to each other, over the object's size
PLACE = (0.005, 0.1)  # share of the surface, in one piece, where scans differ by far more than elsewhere
MISSING = (0.15, 0.5)  # share of the surface that a scan does not show
CLAIM = (1.5, 3.0)  # spread over what the scans' own sigma says


def judge_repeat(found: Repeat) -> Judgement:
    """Whether the scans show one object, whether one stands out, and whether they know how sure they are."""
    rows = found.offsets()
    lost = [k for k, row in enumerate(rows) if row.alignment == "poor"]
    if lost:
        said = f"{'; '.join(_lost(found, k) for k in lost)}: no pose was found in which it fits the others."
        # what else is told of scans that do not lie on each other means nothing
        return Judgement((Light("bad", "One object", said, "Check that all show the same object, whole.", fails=True),))
    lights = [_alike(found)]
    if found.place is not None and lights[0].level == "ok":  # else the whole scan is told of
        lights.append(_place(found))
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


def _lost(found: Repeat, k: int) -> str:
    one = found.others[k] if found.others else None
    return found.names[k] if one is None or not one.lost else _beside(found, k, one)


def _beside(found: Repeat, k: int, one: AgainstOthers) -> str:
    """ "scan 3 of 3, c.ply: 2.4 mm off the others, which are 0.005 mm apart"."""
    which = f"scan {k + 1} of {len(found.names)}, {found.names[k]}"
    return f"{which}: {1e3 * one.off:.3g} mm off the others, which are {1e3 * one.apart:.3g} mm apart"


def _alike(found: Repeat) -> Light:
    """Whether one scan lies further from the others than these from each other."""
    # of those that stand out by more than chance the worst, else the worst of all
    known = [(one.times > one.chance, one.times, k, one) for k, one in enumerate(found.others) if one is not None]
    if not known:
        away = difference(found.spread.offsets[:, 0], found.spread.offsets[:, 1])
        share = away / float(np.linalg.norm(np.ptp(found.spread.at.points, axis=0)))
        judged = level(share, OF_SIZE)
        said = f"The two differ by {1e3 * away:.3g} mm (rms), {100 * share:.2g} % of their size"
        said += "; of two none tells which is off."
        return Light(judged, "Scans alike", said, "Scan it once more; is it one object?" if judged != "ok" else "")
    real, times, k, one = max(known)
    judged = level(times, STANDS_OUT) if real else "ok"
    do = "Look at its report: a slip, another light, warm-up?" if judged != "ok" else ""
    return Light(judged, "Scans alike", f"{_beside(found, k, one)}.", do)


def _place(found: Repeat) -> Light:
    """Where scans show the surface at different places."""
    assert found.place is not None
    place, where = found.place, ", ".join(f"{1e3 * x:.0f}" for x in found.place.centre_m)
    judged = level(place.share, PLACE)
    who = found.names[place.scan] if len(found.names) > 2 else "The one"
    said = f"{who} lies up to {1e3 * place.height_m:.2g} mm off the other"
    said += f"{'s' if len(found.names) > 2 else ''} at a place {1e3 * place.across_m:.0f} mm across"
    said += f" ({place.share:.1%} of the surface), about ({where}) mm of spread.ply."
    return Light(judged, "Same everywhere", said, "Look there: did the object change?" if judged != "ok" else "")


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
