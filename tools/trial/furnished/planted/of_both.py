"""Effects of the depth, the lens, poses and clocks, which both kinds of sensors may have."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from tools.trial.furnished.physics.sensor import Effects
from tools.trial.furnished.planted.plant import Planted, Soil


def depth_scale(soil: Soil) -> Planted:
    a = soil.size(0.004, 0.015)
    return Planted({"scale": a}, f"{a * 100:.2f} %", "depth")


def temperature_drift(soil: Soil) -> Planted:
    if soil.sensor.flight:
        a = soil.size(0.0006, 0.002)
        return Planted({"warming": a}, f"{a * 1e3:.2f} mm/K", "temperature, time")
    a = soil.size(0.004, 0.015) * soil.width / 320
    return Planted({"warming_px": a}, f"{a:.4f} px/K", "temperature, time")


def rolling_shutter(soil: Soil) -> Planted:
    a = abs(soil.size(0.02, 0.035) / soil.height)
    return Planted({"line_delay": a}, f"{a * 1e6:.0f} us per line", "velocity, v")


def timestamp_offset(soil: Soil) -> Planted:
    a = soil.size(0.025, 0.07)
    return Planted({"clock": a}, f"{a * 1e3:.0f} ms", "velocity")


def focal_length(soil: Soil) -> Planted:
    a, camera = soil.size(0.006, 0.015), soil.bench.camera
    true = replace(camera, fx=camera.fx / (1 + a), fy=camera.fy / (1 + a))
    return Planted({"camera": true}, f"{a * 100:.2f} %", "radius")


def principal_point(soil: Soil) -> Planted:
    a, b = soil.rng.normal(0, 0.012, 2) * soil.width * soil.boost
    camera = soil.bench.camera
    true = replace(camera, cx=camera.cx - a, cy=camera.cy - b)
    return Planted({"camera": true}, f"{a:.2f}, {b:.2f} px", "u, v")


def lens_distortion(soil: Soil) -> Planted:
    camera = soil.bench.camera
    k1, k2, *others = camera.distortion
    k1 += soil.size(0.03, 0.1)
    k2 += soil.rng.normal(0, 0.02)
    true = replace(camera, distortion=(k1, k2, *others))
    return Planted({"camera": true}, f"k1 off by {k1 - camera.distortion[0]:.3f}", "radius")


def fixed_pattern(soil: Soil) -> Planted:
    rng, width, height = soil.rng, soil.width, soil.height
    kind, a = rng.integers(3), soil.positive(0.0015, 0.005)
    grain = rng.standard_normal((height, width))
    if kind == 1:
        grain = np.sign(np.arange(width) % 2 - 0.5)[None, :] * np.ones((height, 1)) + 0.3 * grain
    if kind == 2:
        grain = grain + gaussian_filter(grain, width / 25) * width / 12
    words = ["white", "odd/even columns", "rough and smooth"][kind]
    return Planted({"pattern": a * grain / grain.std()}, f"{a * 1e3:.1f} mm rms, {words}", "u, v")


def axial_noise(soil: Soil) -> Planted:
    rng, sensor = soil.rng, soil.sensor
    if not sensor.flight and rng.random() < 0.5:
        a = sensor.sigma_px * rng.uniform(1.6, 2.5)
        size = f"disparity noise x {a / sensor.sigma_px:.2f}"
        return Planted({"sigma_px": a}, size, "disparity", channel="noise")
    if rng.random() < 0.5:
        a = soil.positive(0.0012, 0.003)
        return Planted({"noise_square": a}, f"extra {a * 1e3:.1f} mm z^2", "depth", ["ambient_light"], "noise")
    a = soil.positive(0.0006, 0.002)
    size = f"extra {a * 1e3:.2f} mm theta^2/(pi/2-theta)^2"
    return Planted({"noise_tilt": a}, size, "incidence", ["lateral_noise"], "noise")


def depth_quantization(soil: Soil) -> Planted:
    rng, effects = soil.rng, Effects()
    if soil.sensor.flight:
        a = float(rng.choice([0.01, 0.015, 0.02])) * soil.boost
        soil.sensor.step_m = 0.0
        effects["step_m"], size = a, f"{a * 1e3:.0f} mm"
    else:
        a = float(rng.choice([1 / 4, 1 / 8]) if soil.width == 320 else 1 / 8)
        # more noise than a step would hide it
        soil.sensor.sigma_px = min(soil.sensor.sigma_px, 0.03)
        effects["step_px"], size = a, f"{a} px"
    return Planted(effects, size, "depth", [], "quant", frozenset({"depth_quantization"}))


def refraction(soil: Soil) -> Planted:
    a = soil.positive(0.004, 0.012)
    return Planted({"glass": (a, 1.5)}, f"{a * 1e3:.1f} mm of glass", "radius", ["depth_offset"])


def tracking_drift(soil: Soil) -> Planted:
    rng = soil.rng
    a = np.r_[rng.normal(0, 1, 3) * 0.0012, rng.normal(0, 1, 3) * 0.0008] * soil.boost
    shift, turn = np.linalg.norm(a[:3]), np.linalg.norm(a[3:])
    return Planted({"drift": a}, f"{shift * 1e3:.2f} mm and {turn * 1e3:.2f} mrad a frame", "time")
