"""Laws that no catalogue has, and effects that change the spread or the validity alone."""

from collections.abc import Callable

import numpy as np

from concealed.law import Law

Rng = np.random.Generator


def _unknown(stage: str, acts: Callable[..., object], *variables: str) -> Law:
    return Law("unknown", stage, acts, variables, shifted=True)


def row_wave(rng: Rng, stage: str, unit: float) -> Law:
    """A hum along the rows that grows with the distance."""
    cycles, phase = float(rng.uniform(2.0, 3.5)), float(rng.uniform(0, 6))
    return _unknown(stage, lambda p: unit * p.z * np.sin(2 * np.pi * cycles * p.y + phase), "v", "depth")


def rings(rng: Rng, stage: str, unit: float) -> Law:
    cycles = float(rng.uniform(2.5, 4.0))
    return _unknown(stage, lambda p: unit * np.sin(2 * np.pi * cycles * np.hypot(p.x, p.y)), "radius")


def brightness_wave(rng: Rng) -> Law:
    """A wave in the logarithm of the amplitude, as a companding converter makes."""
    phase = float(rng.uniform(0, 6))
    return _unknown("delay", lambda p: 1e-3 * np.sin(2.5 * np.log(np.maximum(p.amplitude, 20.0)) + phase), "amplitude")


def leak(rng: Rng) -> Law:
    """A constant phasor: the modulation that reaches the samples through the electronics."""
    turns = rng.uniform(0, 2 * np.pi, 3)

    def acts(p, light, modulations):
        return 10.0 * np.exp(1j * turns)[:, None, None] * np.ones(p.z.shape)

    return _unknown("light", acts, "amplitude", "depth")


def beat(rng: Rng, stage: str, unit: float) -> Law:
    """A slow swing in time, larger to one side of the image."""
    period = float(rng.uniform(500, 900))
    return _unknown(stage, lambda p: unit * np.sin(2 * np.pi * p.time / period) * (1 + p.x), "time", "u")


FLIGHT = {
    "row_wave": lambda rng: row_wave(rng, "delay", 1e-3),
    "rings": lambda rng: rings(rng, "delay", 1e-3),
    "brightness_wave": brightness_wave,
    "leak": leak,
    "beat": lambda rng: beat(rng, "delay", 1e-3),
}
MATCHING = {
    "row_wave": lambda rng: row_wave(rng, "disparity", 0.01),
    "rings": lambda rng: rings(rng, "disparity", 0.01),
    "beat": lambda rng: beat(rng, "disparity", 0.01),
}


def noisier(rng: Rng) -> Law:
    factor = float(rng.uniform(1.3, 2.0))
    names = ("axial_noise", "ambient_light", "sensor_interference", "ambient_flicker")
    return Law("axial_noise", "noise", lambda _: factor, ("depth",), accept=names)


def remembering(rng: Rng) -> Law:
    share = float(rng.uniform(0.3, 0.6))
    return Law("temporal_filtering", "filter", lambda _: share, (), accept=("temporal_filtering",))


def darker(rng: Rng) -> Law:
    threshold = float(rng.uniform(250, 600))
    return Law("amplitude_dropout", "dark", lambda _: threshold, ("amplitude",), accept=("amplitude_dropout",))
