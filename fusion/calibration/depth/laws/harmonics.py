"""Periods of the wiggling that a sensor's modulation frequencies give, where the free search knows them to 1 % only."""

from itertools import combinations

from fusion.sensor.view import LIGHT_SPEED

# waves per turn of the phase: unequal halves make 2, harmonics of the light's shape seen in three or four phase steps
# make 3 or 4, and each squared twice as many; a constant phasor makes 1
TURNS = (1, 2, 3, 4, 6, 8)
UNWRAPS = 0.1  # share of the weight, which goes with the squared frequency, below which a modulation only counts turns
STRONG = (2, 3, 4)  # those of two modulations that also make a wave together, as amplitudes weigh the two phases
ALIKE = 1e-3  # share by which two periods differ that no wall tells apart
LEAST, MOST = 0.16, 3.4  # [m] as of the free search


def harmonics(frequencies: tuple[float, ...]) -> tuple[float, ...]:
    """Periods (n,) [m] of the range, from short to long, that waves of these modulations [Hz] can have."""
    total = sum(f**2 for f in frequencies)
    turn = [2 * f / LIGHT_SPEED for f in frequencies if f**2 > UNWRAPS * total]  # phase turns per metre
    rates = [n * k for k in turn for n in TURNS]
    rates += [abs(n * a + sign * n * b) for a, b in combinations(turn, 2) for n in STRONG for sign in (1, -1)]
    found: list[float] = []
    for rate in sorted(rates, reverse=True):
        period = 1 / rate if rate > 1 / MOST else MOST
        if LEAST <= period < MOST and (not found or period > found[-1] * (1 + ALIKE)):
            found.append(period)
    return tuple(found)
