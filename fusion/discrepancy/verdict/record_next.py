"""What to record next, so that look-alikes part."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS


def record_next(effect: Effect, alike: list[str]) -> str:
    """What to vary so that look-alikes part: the variables that one of them has and the other has not."""
    if not alike:
        return ""
    kinds = {kind.name: kind for kind in EFFECTS}
    other = kinds.get(alike[0])
    own = set(effect.variables) ^ set(other.variables if other else ())
    vary = ", ".join(sorted(own)) or ", ".join(effect.variables)
    return (
        f"the same target with other values of {vary} and nothing else changed: {effect.name} and {alike[0]} part there"
    )
