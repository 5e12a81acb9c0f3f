"""Effects of time of flight: of its light, its samples, its range."""

import numpy as np

from tools.trial.furnished.physics.sensor import C
from tools.trial.furnished.planted.plant import Planted, Soil
from tools.trial.furnished.rooms.things import things


def depth_offset(soil: Soil) -> Planted:
    a = soil.size(0.005, 0.02)
    return Planted({"offset": a}, f"{a * 1e3:.1f} mm", "none")


def cyclic_error(soil: Soil) -> Planted:
    """Harmonics that fold onto the fundamental with so many taps."""
    rng, k = soil.rng, soil.boost
    if soil.sensor.taps == 4:
        orders = {3: rng.uniform(0.03, 0.1) * k * soil.sign, 5: rng.uniform(-0.03, 0.03) * k}
    else:
        orders = {2: rng.uniform(0.02, 0.06) * k * soil.sign, 4: rng.uniform(-0.015, 0.015) * k}
        orders[5] = rng.uniform(-0.01, 0.01) * k
    fastest = max(soil.sensor.frequencies)
    metres = max(map(abs, orders.values())) * (C / 2 / fastest) / 6.283
    told = {order: round(float(size), 4) for order, size in orders.items()}
    size = f"harmonics {told}, about {metres * 1e3:.1f} mm on the {fastest / 1e6:.0f} MHz phase"
    return Planted({"harmonics": orders}, size, "range")


def amplitude_error(soil: Soil) -> Planted:
    a = soil.size(0.002, 0.008)
    power = float(soil.rng.choice([0.5, 1.0, 1.0]))
    size = f"{a * 1e3:.1f} mm at 1000 counts, exponent {power}"
    return Planted({"amplitude": (a, power, 1000.0)}, size, "amplitude")


def multipath(soil: Soil) -> Planted:
    k = soil.boost
    share = min(1.0, 0.5 * k + 0.3) if k <= 1 else 1.0
    return Planted({"bounces": share}, f"strength {share:.2f}", "neighbours")


def stray_light(soil: Soil) -> Planted:
    share = min(soil.positive(0.02, 0.06), 0.15)
    width = soil.rng.uniform(0.06, 0.25) * soil.width
    size = f"fraction {share:.3f}, width {width:.0f} px"
    return Planted({"stray": (share, width)}, size, "amplitude, neighbours")


def mixed_pixels(soil: Soil) -> Planted:
    soil.sensor.parts = 4
    return Planted({"fill": 1.0}, "fill 1", "edge")


def pixel_crosstalk(soil: Soil) -> Planted:
    share = min(soil.positive(0.04, 0.12), 0.3)
    return Planted({"crosstalk": share}, f"fraction {share:.3f}", "edge", ["defocus", "mixed_pixels"])


def defocus(soil: Soil) -> Planted:
    a = soil.positive(0.6, 1.3)
    return Planted({"defocus": a}, f"sigma {a:.2f} px", "edge", ["pixel_crosstalk", "mixed_pixels"])


def motion_artifact(soil: Soil) -> Planted:
    a = soil.positive(0.008, 0.02)
    size = f"{a * 1e3:.0f} ms over all taps"
    return Planted({"tap_delay": a / soil.sensor.taps}, size, "velocity, edge", ["motion_blur"])


def column_delay(soil: Soil) -> Planted:
    rng = soil.rng
    a = soil.size(0.008, 0.03) / soil.width
    b = 0.0 if rng.random() < 0.6 else a * rng.uniform(-0.7, 0.7)
    return Planted({"delays": (a, b)}, f"{a * 1e6:.0f} um/px along u, {b * 1e6:.0f} along v", "u, v")


def ambient_light(soil: Soil) -> Planted:
    a = soil.sensor.ambient * soil.rng.uniform(6, 25) * soil.boost
    size = f"background electrons x {a / soil.sensor.ambient:.0f}"
    return Planted({"ambient": a}, size, "amplitude", ["axial_noise"], "noise")


def saturation(soil: Soil) -> Planted:
    counts = _seen(soil)
    a = float(np.quantile(counts, soil.rng.uniform(0.9, 0.97)))
    return Planted({"saturation": a}, f"above {a:.0f} counts", "amplitude", channel="dropout")


def amplitude_dropout(soil: Soil) -> Planted:
    counts = _seen(soil)
    a = float(np.quantile(counts, soil.rng.uniform(0.04, 0.15)))
    without = frozenset({"amplitude_dropout"})
    return Planted({"dropout": (a, a * 0.1)}, f"below {a:.0f} counts", "amplitude", [], "dropout", without)


def _seen(soil: Soil) -> np.ndarray:
    """[counts] of all that is seen; the sensor has no threshold of its own any more."""
    counts = np.concatenate([image[seen] for image, seen in soil.amplitudes()])
    soil.sensor.dropout = None
    return counts


def subsurface_scattering(soil: Soil) -> Planted:
    parts = soil.bench.parts
    standing = things(parts)
    chosen = list(soil.rng.permutation(standing))[: max(1, len(standing) // 3)] or [len(parts) - 1]
    a = soil.positive(0.006, 0.02)
    size = f"path {a * 1e3:.1f} mm in {', '.join(parts[i].name for i in chosen)}"
    return Planted({"inside": (chosen, a)}, size, "material", ["reference_shape_error"])


def phase_wrapping(soil: Soil) -> Planted:
    return Planted({"folds": True}, f"folds at {C / 2 / soil.sensor.frequencies[0]:.2f} m", "range")


def emitter_parallax(soil: Soil) -> Planted:
    a = soil.size(0.03, 0.07)
    return Planted({"lamp_at": a}, f"{a * 1e3:.0f} mm", "u, range", ["column_delay"])


def temporal_filtering(soil: Soil) -> Planted:
    a = soil.rng.uniform(0.4, 0.7)
    return Planted({"memory": a}, f"memory {a:.2f}", "time, velocity")
