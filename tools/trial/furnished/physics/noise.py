"""Noise of a frame, derivatives by the pose, where depth jumps: what estimates of visibility need."""

import numpy as np
from scipy.ndimage import maximum_filter

from tools.trial.furnished.physics.bench import Bench
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import Effects
from tools.trial.furnished.physics.world import SeenPixels


def extra_sigma(effects: Effects, hits: SeenPixels) -> Array | float:
    """(h, w) [m] noise that a concealed law adds, or 0."""
    if "noise_square" in effects:
        return effects["noise_square"] * np.nan_to_num(hits.z) ** 2
    if "noise_tilt" in effects:
        tilt = np.arccos(np.clip(hits.cosine, 0, 1))
        return effects["noise_tilt"] * np.minimum(tilt**2 / np.maximum(np.pi / 2 - tilt, 0.08) ** 2, 40)
    return 0


def depth_sigma(bench: Bench, effects: Effects, hits: SeenPixels, amplitude: Array | None) -> Array:
    """(h, w) [m] noise of the depth of one frame, rounding included, by the sensor's own law and what is concealed."""
    sensor = bench.sensor
    if sensor.flight:
        assert amplitude is not None
        own = sensor.range_sigma(amplitude, effects.get("ambient")) / hits.stretch
    else:
        grain, step = effects.get("sigma_px", sensor.sigma_px), effects.get("step_px", sensor.step_px)
        own = np.nan_to_num(hits.z) ** 2 / sensor.pixel_metres * np.sqrt(grain**2 + step**2 / 12)
    rounded = effects.get("step_m", sensor.step_m)
    return np.asarray(np.sqrt(own**2 + extra_sigma(effects, hits) ** 2 + rounded**2 / 12))


def by_pose(hits: SeenPixels) -> Array:
    """(h, w, 6) change of depth by a shift [m] and a turn [rad] of the camera in its own frame."""
    z = np.nan_to_num(hits.z)
    slope = (hits.normal * hits.direction).sum(-1)
    slope = np.where(np.abs(slope) < 0.05, 0.05 * np.sign(slope - 1e-9), slope)
    turned = z[..., None] * np.cross(hits.direction, hits.normal)
    return -np.concatenate([hits.normal, turned], -1) / slope[..., None]


def edges(z: Array, radius: int) -> Array:
    """(h, w) whether a depth jump or a hole is within `radius` [px]."""
    known = np.nan_to_num(z, nan=0.0)
    wide = np.pad(known, 1, mode="reflect", reflect_type="odd")
    across = np.abs(wide[1:-1, :-2] - 2 * known + wide[1:-1, 2:])
    down = np.abs(wide[:-2, 1:-1] - 2 * known + wide[2:, 1:-1])
    jumps = np.maximum(across, down) > 0.03 * known + 0.02
    return np.asarray(maximum_filter(jumps.astype(np.uint8), size=2 * radius + 1) > 0)
