"""How many frames of a recording served."""

from collections.abc import Mapping

from fusion.results.light import Light, level

LOST_SHARE = (0.05, 0.3)  # good up to the first, a problem above the second (guess)
FEW = 0.5  # of a scan that lost more, what is left says little of what was recorded
NAMED = 8  # frames


def frames_light(total: int, rejected: Mapping[int, str]) -> Light:
    """One light for the frames that were left out, with the commonest reason."""
    said, do = f"{total - len(rejected)} of {total} frames were used", ""
    if rejected:
        reasons = [reason.rstrip(".") for reason in rejected.values()]
        common = max(sorted(set(reasons)), key=reasons.count)
        which = ", ".join(map(str, sorted(rejected)[:NAMED])) + (", ..." if len(rejected) > NAMED else "")
        said += f"; rejected: {which}, most often as {common}"
        do = "Move slowly, and keep what is scanned in the picture, hands and people out of it."
    lost = len(rejected) / max(total, 1)
    return Light(level(lost, LOST_SHARE), "Frames", f"{said}.", do, fails=lost > FEW)
