"""The candidate laws for each kind of sensor: what may be wrong with its depth, from nothing to a whole stack."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from fusion.calibration.depth.laws.harmonics import LEAST, MOST
from fusion.calibration.depth.laws.terms import (
    LawTerm,
    common_terms,
    curve_terms,
    flight_terms,
    radial_terms,
    triangulation_terms,
    wave_terms,
)
from fusion.geometry.camera import TRIANGULATING, Principle

# periods of the wiggling [m], 2 % apart: c / 2f over a number of phase steps, for modulations of 16 to 160 MHz with
# their second harmonics; between two of them a wave of 0.2 m shifts by a third of a radian over 2 m
PERIODS = tuple(float(p) for p in np.geomspace(LEAST, MOST, 155))
MOST_WAVES = 8  # three modulations with two harmonics each, and two for what they make together
# linear over the image: delays over the chip of a time of flight, a stored pattern that lies askew; only walls whose
# tilts are known (boards) show them
DELAYS, TILTS = ("delay u", "delay v"), ("tilt u", "tilt v")
# what the brightness may do: one power of the darkness, or two shapes that make a curve together
BRIGHTNESS = (("amplitude",), ("amplitude^2",), ("amplitude^2", "amplitude log"))


@dataclass(frozen=True)
class CandidateLaw:
    """A law that may be chosen."""

    name: str  # as it stands in the report
    keys: tuple[str, ...]  # its terms
    waves: int = 0  # how many waves are added; their periods are searched
    # "", or "map" / "stack": what is left per pixel is taken too, the same at all distances or for each
    surface: str = ""
    periods: tuple[float, ...] = ()  # [m] that they may have; empty: any

    @property
    def numbers(self) -> int:
        """How many numbers are fitted; the surface is not counted."""
        return len(self.keys) + (2 if self.periods else 3) * self.waves

    @property
    def tabulated(self) -> bool:
        """True when its curve is a table already."""
        return any(key.startswith("curve") or key == "amplitude log" for key in self.keys)

    @property
    def shaped(self) -> bool:
        """True when it says anything over the image beside what a distance does: so might the shape of the walls."""
        return bool(self.surface) or any(key.startswith("radius") for key in self.keys)

    @property
    def over_distance(self) -> int:
        """How many numbers its curve over distance has that only other walls can tell, not other pixels."""
        return sum(key in ("offset", "scale", "disparity") or key.startswith("curve") for key in self.keys)


def terms_for(
    principle: Principle, nodes: tuple[float, ...], ir_reference: float | None, periods: tuple[float, ...] = ()
) -> list[LawTerm]:
    """All terms that a sensor of this principle can have.

    Args:
        nodes: [m] of the curve of straight pieces.
        periods: [m] that waves have by the modulation.
    """
    terms = common_terms()
    if principle in TRIANGULATING:
        terms += triangulation_terms()
    elif principle == Principle.TIME_OF_FLIGHT:
        terms += flight_terms(ir_reference) + wave_terms((*PERIODS, *periods))
    else:
        terms += radial_terms()
    return terms + curve_terms(nodes)


def candidates_for(principle: Principle, terms: list[LawTerm], periods: tuple[float, ...] = ()) -> list[CandidateLaw]:
    """Candidates made of the terms at hand, from simple to rich; "nothing" is the first. `periods` [m] as above."""
    keys = {term.key for term in terms}
    curves = [c for c in _curves(principle, terms, periods) if set(c.keys) <= keys]
    shapes: list[tuple[str, tuple[str, ...]]] = [("", ())]
    shapes += [("radius^2", ("radius^2",))] if "radius^2" in keys else []
    found = [
        CandidateLaw(
            " + ".join(filter(None, (c.name, name))) or "nothing", (*c.keys, *shape), c.waves, periods=c.periods
        )
        for name, shape in shapes
        for c in curves
    ]
    for name, both in (("delay", DELAYS), ("tilt", TILTS)):
        if keys.issuperset(both):
            found += [_tilted(c, name, both) for c in found if c.periods or not c.waves]
    return found + ([_glossy(c) for c in found if not c.waves] if "gloss" in keys else [])


def _glossy(candidate: CandidateLaw) -> CandidateLaw:
    """The same before a board that mirrors."""
    return replace(candidate, name=f"{candidate.name} + the board's gloss", keys=(*candidate.keys, "gloss"))


def _tilted(candidate: CandidateLaw, name: str, both: tuple[str, ...]) -> CandidateLaw:
    """The same with what is linear over the image."""
    name = name if candidate.name == "nothing" else f"{candidate.name} + {name}"
    return replace(candidate, name=name, keys=(*candidate.keys, *both))


def richer(candidate: CandidateLaw) -> CandidateLaw:
    """The same with a radial term of the fourth power."""
    return replace(candidate, name=f"{candidate.name}, ^4", keys=(*candidate.keys, "radius^4"))


def richest(candidates: list[CandidateLaw], keys: tuple[str, ...]) -> CandidateLaw:
    """A law that leaves over little but noise: the longest, with brightness, delays and all radial terms in it."""
    longest = max(candidates, key=lambda c: ("radius^2" in c.keys, c.numbers))
    more = ("radius^4", *BRIGHTNESS[-1], *DELAYS, *TILTS, "gloss")
    return replace(longest, keys=(*longest.keys, *(key for key in more if key in keys and key not in longest.keys)))


def _curves(principle: Principle, terms: list[LawTerm], periods: tuple[float, ...]) -> list[CandidateLaw]:
    """Laws over the distance."""
    keys = {term.key for term in terms}
    simple = ("offset", "scale", *(["disparity"] if principle in TRIANGULATING else []))
    found = [CandidateLaw(" + ".join(some), some) for n in range(len(simple) + 1) for some in combinations(simple, n)]
    if any(term.effect == "cyclic_error" for term in terms):
        base: tuple[str, ...] = ("offset",) if "offset" in keys else ()
        found += _wavy(base, periods)
        found += [c for c in _wavy((*base, "scale"), periods) if c.periods]
    found += _by_brightness(keys, periods)
    pieces = tuple(term.key for term in terms if term.key.startswith("curve"))
    if len(pieces) > 1:
        found.append(CandidateLaw("curve", pieces))
    return found


def _by_brightness(keys: set[str], periods: tuple[float, ...]) -> list[CandidateLaw]:
    """Laws with the brightness in them; the first power beside waves too."""
    found = []
    straight = [base for base in ((), ("offset",), ("offset", "scale")) if keys.issuperset(base)]
    for shape in BRIGHTNESS:
        if keys.issuperset(shape):
            name = "brightness curve" if len(shape) > 1 else shape[0]
            found += [CandidateLaw(" + ".join((*base, name)), (*base, *shape)) for base in straight]
    if "amplitude" in keys and any(key.startswith("sin ") for key in keys):
        base = ("offset", "amplitude") if "offset" in keys else ("amplitude",)
        found += _wavy(base, periods)
    return found


def _wavy(base: tuple[str, ...], periods: tuple[float, ...]) -> list[CandidateLaw]:
    """Waves of any period beside these terms, and of the periods that the modulation gives."""
    found = []
    for word, allowed in (("wave", ()), ("harmonic", periods)):
        for n in range(1, MOST_WAVES + 1) if allowed or word == "wave" else ():
            name = " + ".join((*base, f"{n} {word}" + "s" * (n > 1)))
            found.append(CandidateLaw(name, base, n, periods=allowed))
    return found
