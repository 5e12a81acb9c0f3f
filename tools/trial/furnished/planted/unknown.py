"""Laws that no catalogue has."""

import numpy as np

from tools.trial.furnished.planted.plant import Planted, Soil


def ghost(soil: Soil) -> Planted:
    a = soil.positive(0.02, 0.06)
    size = f"point-mirrored ghost of {a * 100:.1f} %"
    return Planted({"ghost": a}, size, "mirrored image, amplitude", ["stray_light"])


def penetration(soil: Soil) -> Planted:
    a = soil.positive(0.004, 0.012)
    return Planted({"penetration": a}, f"{a * 1e3:.1f} mm (1/cos - 1)", "incidence", ["tabulated"])


def ripple(soil: Soil) -> Planted:
    a, rate = soil.positive(0.003, 0.008), soil.rng.uniform(0.6, 2.2)
    return Planted({"ripple": (a, rate)}, f"{a * 1e3:.1f} mm at {rate:.2f} Hz", "time", ["sensor_interference"])


def jump(soil: Soil) -> Planted:
    first = len(soil.recordings) // 2 + int(soil.rng.integers(0, 2))
    a = soil.size(0.006, 0.02)
    size = f"{a * 1e3:.1f} mm from recording {first} on"
    return Planted({"jump": (first, a)}, size, "time (recordings)", ["depth_offset"])


def square(soil: Soil) -> Planted:
    a = soil.size(0.004, 0.012)
    return Planted({"square": a}, f"{a * 1e3:.1f} mm (r - 1.2)^2", "range", ["tabulated"])


def gain(soil: Soil) -> Planted:
    counts = np.concatenate([image.ravel() for image, _ in soil.amplitudes()])
    threshold = float(np.quantile(counts[counts > 1], soil.rng.uniform(0.3, 0.6)))
    a = soil.size(0.005, 0.012)
    size = f"{a * 1e3:.1f} mm below {threshold:.0f} counts (second gain)"
    return Planted({"gain": (threshold, a)}, size, "amplitude", ["amplitude_error", "tabulated"])


def sectors(soil: Soil) -> Planted:
    a, order = soil.positive(0.003, 0.008), int(soil.rng.choice([3, 5]))
    also = ["fixed_pattern", "tabulated"]
    return Planted({"sectors": (a, order)}, f"{a * 1e3:.1f} mm sin({order} azimuth)", "u, v (azimuth)", also)
