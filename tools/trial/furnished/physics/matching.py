"""Triangulation: a disparity for each pixel, what spoils it, and the depth that it gives with the stated numbers."""

import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter, maximum_filter

from tools.trial.furnished.physics.bench import Bench, Instant
from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import Effects
from tools.trial.furnished.physics.world import SeenPixels

LIFT = 0.003  # [m] off a surface, before a shadow is asked for


def matched(
    bench: Bench, instant: Instant, effects: Effects, noise: np.random.Generator | None
) -> tuple[Array, SeenPixels]:
    """(h, w) [m] depth, NaN where nothing is or a shadow lies; what is seen."""
    sensor, camera = bench.sensor, effects.get("camera", bench.camera)
    if "jitter" in effects and noise is not None:
        hits = _jittered(bench, instant.pose, camera, effects["jitter"], noise)
    else:
        hits = bench.cast(instant.pose, camera, key=instant.key)
    z = hits.z.copy()
    if "glass" in effects:
        thickness, index = effects["glass"]
        cosine = 1 / hits.stretch
        z = z - thickness * (1 - cosine / np.sqrt(index**2 - 1 + cosine**2))
    disparity = _widened(sensor.pixel_metres / z, effects.get("window", sensor.window))
    disparity = _shifted(bench, disparity, z, instant.time, effects, camera)
    for speckle in _speckles(bench, instant, effects, noise is not None, disparity.shape):
        disparity = disparity + speckle
    if noise is not None:
        grain = noise.standard_normal(disparity.shape)
        if sensor.correlation_px:
            grain = gaussian_filter(grain, sensor.correlation_px / 2, mode="wrap")
            grain /= sensor.spread
        disparity = disparity + effects.get("sigma_px", sensor.sigma_px) * grain
    step = effects.get("step_px", sensor.step_px)
    if noise is not None and step:
        disparity = np.round(disparity / step) * step
    depth = sensor.pixel_metres / np.maximum(disparity, 1e-3)
    return np.where(_shadow(bench, instant, hits, camera), np.nan, depth), hits


def _widened(disparity: Array, window: int) -> Array:
    """Near surfaces widen by half the window: a hard maximum."""
    if not window:
        return disparity
    known = np.nan_to_num(disparity)
    nearest = maximum_filter(known, size=window)
    jump = np.isfinite(disparity) & (nearest - known > 1.2 + 0.06 * known)
    return np.where(jump, nearest, disparity)


def _shifted(bench: Bench, d: Array, z: Array, time: float, effects: Effects, camera: StatedCamera) -> Array:
    """(h, w) [px] the disparity with all that is no noise."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    if "disparity_offset" in effects:
        d = d + effects["disparity_offset"]
    if "disparity_map" in effects:
        d = d + effects["disparity_map"]
    if "disparity_tilt" in effects:
        roll, pitch = effects["disparity_tilt"]
        d = d + camera.fx * (roll * y + pitch * x * y)
    if "locking" in effects:
        size, period = effects["locking"]
        d = d + size * np.sin(2 * np.pi * d / period)
    if "bands" in effects:
        d = d + effects["bands"][None, :]
    if "warming_px" in effects:
        d = d + effects["warming_px"] * bench.warmth(time)
    if "turning" in effects:
        d = d + camera.fx * effects["turning"] * bench.warmth(time) * (x - bench.sensor.baseline / z)
    if "slope" in effects:
        d = d + effects["slope"] * np.gradient(np.nan_to_num(d, nan=0.0), axis=1).clip(-1, 1)
    return d


def _speckles(bench: Bench, instant: Instant, effects: Effects, noisy: bool, shape: tuple[int, ...]) -> list[Array]:
    """(h, w) [px] noise that stands still while the camera does: the concealed one, and that of the sensor."""
    kinds = [(*effects["speckle"], 1)] if "speckle" in effects else []
    if bench.sensor.speckle and noisy:
        kinds.append((*bench.sensor.speckle, 2))
    out = []
    for sigma, length, salt in kinds:
        seed = [bench.seed, 91, instant.recording, salt, instant.frame if instant.moving else 0]
        grain = gaussian_filter(np.random.default_rng(seed).standard_normal(shape), length / 2, mode="wrap")
        out.append(sigma * grain / grain.std())
    return out


def _shadow(bench: Bench, instant: Instant, hits: SeenPixels, camera: StatedCamera) -> Array:
    """(h, w) whether the projector, or the second camera, does not see what the pixel sees."""
    key = ("shadow", instant.key, camera)
    if instant.key is not None and key in bench.casts:
        return bench.casts[key]
    rows = np.broadcast_to(instant.pose, (camera.height, 4, 4))
    lifted = hits.direction * np.nan_to_num(hits.z, nan=1)[..., None] + hits.normal * LIFT
    start = np.einsum("hij,hwj->hwi", rows[:, :3, :3], lifted) + rows[:, None, :3, 3]
    other = np.array([bench.sensor.baseline, 0, 0.0])
    end = np.einsum("hij,j->hi", rows[:, :3, :3], other)[:, None] + rows[:, None, :3, 3]
    blocked = bench.world.blocked(start, np.broadcast_to(end, start.shape))
    if instant.key is not None:
        bench.casts[key] = blocked
    return blocked


def _jittered(bench: Bench, T: Array, camera: StatedCamera, sigma: float, noise: np.random.Generator) -> SeenPixels:
    """Each ray nudged by itself [px]."""
    straight, direction = bench.cast(T, camera), bench.directions(camera)
    nudged = direction.copy()
    nudged[..., 0] += noise.normal(0, sigma, direction.shape[:2]) / camera.fx
    nudged[..., 1] += noise.normal(0, sigma, direction.shape[:2]) / camera.fy
    return dataclasses.replace(bench.world.cast(T, nudged), stretch=straight.stretch, direction=direction)
