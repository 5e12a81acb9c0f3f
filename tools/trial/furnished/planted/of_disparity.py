"""Effects of triangulation. Sizes in pixels grow with the width of the image."""

import numpy as np
from scipy.ndimage import gaussian_filter

from tools.trial.furnished.planted.plant import Planted, Soil


def disparity_offset(soil: Soil) -> Planted:
    a = soil.size(0.08, 0.25) * soil.width / 320
    return Planted({"disparity_offset": a}, f"{a:.3f} px", "depth, disparity")


def disparity_distortion(soil: Soil) -> Planted:
    white = soil.rng.standard_normal((soil.height, soil.width))
    grain = gaussian_filter(white, soil.width / 9, mode="reflect")
    grain -= grain.mean()
    a = soil.positive(0.06, 0.2) * soil.width / 320
    return Planted({"disparity_map": a * grain / grain.std()}, f"{a:.3f} px rms", "u, v", ["fixed_pattern"])


def disparity_tilt(soil: Soil) -> Planted:
    roll = soil.size(0.0008, 0.0025)
    pitch = soil.rng.normal(0, 0.001) * soil.boost
    size = f"baseline turned by {roll * 1e3:.2f} mrad (roll), {pitch * 1e3:.2f} (pitch)"
    return Planted({"disparity_tilt": (roll, pitch)}, size, "u, v")


def pixel_locking(soil: Soil) -> Planted:
    a = soil.positive(0.04, 0.1) * (0.6 + 0.4 * (soil.width == 320))
    period = float(soil.rng.choice([1.0, 1.0, 0.5]))
    return Planted({"locking": (a, period)}, f"{a:.3f} px, period {period}", "disparity")


def vertical_banding(soil: Soil) -> Planted:
    rng, width = soil.rng, soil.width
    n = rng.integers(5, 9)
    columns = np.sort(rng.integers(6, width - 6, n))
    steps = rng.choice([-1, 1], n) * rng.uniform(0.06, 0.16) * soil.boost * width / 320
    bands = np.zeros(width)
    for column, step in zip(columns, steps, strict=True):
        bands[column:] += step
    bands -= bands.mean()
    return Planted({"bands": bands}, f"{abs(steps[0]):.3f} px at {n} columns", "u")


def speckle_noise(soil: Soil) -> Planted:
    a = soil.positive(0.05, 0.12) * soil.width / 320
    speckle = (a, soil.rng.uniform(2.5, 6))
    soil.sensor.speckle = None
    also = ["fixed_pattern"] if len(soil.recordings) < 4 else []
    return Planted({"speckle": speckle}, f"{a:.3f} px", "none", also, without=frozenset({"speckle_noise"}))


def projector_thermal_drift(soil: Soil) -> Planted:
    a = soil.size(1e-4, 4e-4)
    return Planted({"turning": a}, f"{a * 1e6:.0f} ppm/K", "temperature, u", ["temperature_drift"])


def edge_fattening(soil: Soil) -> Planted:
    a = int(soil.rng.choice([5, 7, 9]))
    soil.sensor.window = 0
    return Planted({"window": a}, f"window {a} px", "edge")


def lateral_noise(soil: Soil) -> Planted:
    a = soil.positive(0.5, 1.2)
    return Planted({"jitter": a}, f"{a:.2f} px", "edge", ["axial_noise"], "noise")


def slope(soil: Soil) -> Planted:
    a = soil.size(0.2, 0.5)
    return Planted({"slope": a}, f"{a:.2f} times the horizontal slope of the disparity", "incidence, u", ["tabulated"])
