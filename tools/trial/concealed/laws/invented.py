"""Laws that no catalogue has, and effects that change the spread or the validity alone."""

from collections.abc import Callable

import numpy as np

from tools.trial.concealed.laws.law import Law

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


NOISE = ("axial_noise", "ambient_light", "sensor_interference", "ambient_flicker")
LOST = ("ambient_light", "amplitude_dropout", "specular_reflection")


def noisier(rng: Rng) -> Law:
    factor = float(rng.uniform(1.3, 2.0))
    return Law("axial_noise", "noise", lambda p: factor * np.ones(p.z.shape), ("depth",), accept=NOISE)


def noisier_far(rng: Rng) -> Law:
    """Noise that grows faster with the distance than the model has it."""
    rate = float(rng.uniform(0.3, 0.8))
    return Law("axial_noise", "noise", lambda p: 1 + rate * np.nan_to_num(p.z) ** 2 / 4, ("depth",), accept=NOISE)


def noisier_steep(rng: Rng) -> Law:
    """Noise that grows with the angle of incidence."""
    rate = float(rng.uniform(1.0, 3.0))

    def acts(p):
        return 1 + rate * (1 / np.maximum(p.shot.hits.cosine, 0.2) ** 2 - 1)

    return Law("axial_noise", "noise", acts, ("incidence",), accept=("axial_noise",))


def remembering(rng: Rng) -> Law:
    share = float(rng.uniform(0.3, 0.6))
    known = ("memory", share)
    return Law("temporal_filtering", "filter", lambda _: share, (), accept=("temporal_filtering",), parameter=known)


def darker(rng: Rng) -> Law:
    threshold = float(rng.uniform(250, 600))
    known = ("ir_threshold", threshold)
    names = ("amplitude_dropout",)
    return Law("amplitude_dropout", "dark", lambda _: threshold, ("amplitude",), accept=names, parameter=known)


def brighter(rng: Rng) -> Law:
    threshold = float(rng.uniform(4000, 9000))
    known = ("ir_threshold", threshold)
    return Law("saturation", "bright", lambda _: threshold, ("amplitude",), accept=("saturation",), parameter=known)


def losing_far(rng: Rng) -> Law:
    """Pixels that come and go, more of them the farther: a pattern that drowns in other light."""
    share = float(rng.uniform(0.02, 0.06))
    return Law("ambient_light", "loss", lambda p: np.minimum(share * p.z**2, 0.8), ("depth",), accept=LOST)


SPREAD_MATCHING: dict[str, Callable[[Rng], Law]] = {
    "noisier": noisier,
    "noisier_far": noisier_far,
    "noisier_steep": noisier_steep,
    "remembering": remembering,
    "losing_far": losing_far,
}
SPREAD_FLIGHT: dict[str, Callable[[Rng], Law]] = {
    "noisier": noisier,
    "noisier_far": noisier_far,
    "noisier_steep": noisier_steep,
    "remembering": remembering,
    "darker": darker,
    "brighter": brighter,
}
