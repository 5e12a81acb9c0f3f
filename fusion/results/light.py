"""One judged statement, as terminal, page and JSON tell it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

LEVELS = ("ok", "warning", "bad")


@dataclass(frozen=True)
class Light:
    """One judged statement."""

    level: str  # "ok", "warning" or "bad"
    subject: str  # what is judged, two or three words ("Frames used")
    reason: str  # one sentence that says why
    do: str = ""  # what a person can do about it, one sentence; "" when there is nothing to do
    fails: bool = False  # the result itself is wrong, not only doubtful


def note(subject: str, level: str, text: str) -> Light:
    """A light of a sentence that others wrote."""
    return Light(level, subject, f"{text[:1].upper()}{text[1:].rstrip('.')}.")


def worst_first(lights: Iterable[Light]) -> tuple[Light, ...]:
    """Each light once, the worst first, of these what makes the result wrong; equals keep their order."""
    return tuple(sorted(dict.fromkeys(lights), key=lambda light: (-LEVELS.index(light.level), not light.fails)))


def level(value: float, limits: tuple[float, float]) -> str:
    """ "ok" up to the first limit, "bad" above the second or when unknown (NaN), else "warning"."""
    if not value <= limits[1]:
        return "bad"
    return "ok" if value <= limits[0] else "warning"


# of what frames show, what contradicts the surface that all made: good up to the first, a problem above the second
# (guess)
AGAINST = (0.02, 0.08)
LOST_SHARE = (0.05, 0.3)  # good up to the first, a problem above the second (guess)
FEW = 0.5  # of a scan that lost more, what is left says little of what was recorded
NAMED = 8  # frames


def frames_light(total: int, rejected: Mapping[int, str], limits: tuple[float, float] = LOST_SHARE) -> Light:
    """One light for the frames that were left out, with the commonest reason."""
    said, do = f"{total - len(rejected)} of {total} frames were used", ""
    if rejected:
        reasons = [reason.rstrip(".") for reason in rejected.values()]
        common = max(sorted(set(reasons)), key=reasons.count)
        which = ", ".join(map(str, sorted(rejected)[:NAMED])) + (", ..." if len(rejected) > NAMED else "")
        said += f"; rejected: {which}, most often as {common}"
        do = "Move slowly, and keep what is scanned in the picture, hands and people out of it."
    lost = len(rejected) / max(total, 1)
    return Light(level(lost, limits), "Frames", f"{said}.", do, fails=lost > FEW)
