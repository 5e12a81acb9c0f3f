"""A recording: depth and amplitude of each frame, with what acts on the range, the depth and from frame to frame."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tools.trial.furnished.physics.bench import Bench, CameraRun, Instant, Key
from tools.trial.furnished.physics.flight import flight
from tools.trial.furnished.physics.matching import matched
from tools.trial.furnished.physics.noise import extra_sigma
from tools.trial.furnished.physics.poses import Array, moved
from tools.trial.furnished.physics.sensor import Effects, any_of
from tools.trial.furnished.physics.world import SeenPixels

CLOSEST, FARTHEST = 0.05, 12  # [m]
CHANGING = ("warming_px", "turning", "drift")  # a camera that stands still sees something else in each frame


@dataclass(frozen=True)
class TakenFrames:
    """Attributes:
    depth: (frames, h, w) [m], NaN where nothing is; lists.
    amplitude: (frames, h, w) [counts], None where the sensor has none.
    hits: what is seen in each frame.
    """

    depth: list[Array]
    amplitude: list[Any]
    hits: list[SeenPixels]


def record(bench: Bench, recording: CameraRun, effects: Effects, noisy: bool) -> TakenFrames:
    """Without noise nothing is rounded either."""
    rng = np.random.default_rng([bench.seed, 17, recording.index]) if noisy else None
    taken = TakenFrames([], [], [])
    raw: tuple[Array, Any, SeenPixels] | None = None
    before: Array | None = None
    for frame, time in enumerate(recording.times):
        same = recording.static and not noisy and not any_of(effects, CHANGING)
        if raw is None or not same:
            raw = _raw(bench, _instant(bench, recording, frame, effects), effects, rng)
        first, amplitude, hits = raw
        z = _depth(bench, first, amplitude, time, effects) if bench.sensor.flight else first
        z = _laws(z, recording.index, effects)
        sigma = extra_sigma(effects, hits)
        if rng is not None and np.ndim(sigma):
            z = z + sigma * rng.standard_normal(z.shape)
        if "memory" in effects:
            if before is not None:
                memory = effects["memory"]
                z = np.where(np.isfinite(before) & np.isfinite(z), memory * before + (1 - memory) * z, z)
            before = z
        if bench.sensor.flight:
            seed = [bench.seed, 23, recording.index, frame]
            z = _without_lost(bench, z, amplitude, effects, np.random.default_rng(seed))
        z = np.where((z > CLOSEST) & (z < FARTHEST), z, np.nan)
        step = effects.get("step_m", bench.sensor.step_m)
        if noisy and step:
            z = np.round(z / step) * step
        taken.depth.append(z)
        taken.amplitude.append(amplitude)
        taken.hits.append(hits)
    return taken


def _raw(
    bench: Bench, instant: Instant, effects: Effects, rng: np.random.Generator | None
) -> tuple[Array, Any, SeenPixels]:
    """Range or depth, amplitude or None, what is seen."""
    if bench.sensor.flight:
        return flight(bench, instant, effects, rng)
    depth, hits = matched(bench, instant, effects, rng)
    return depth, None, hits


def _instant(bench: Bench, recording: CameraRun, frame: int, effects: Effects) -> Instant:
    time = recording.times[frame]
    clock = effects.get("clock", 0)
    drifts = "drift" in effects

    def path(moment: float) -> Array:
        pose = recording.true(moment, time)
        return pose @ moved(effects["drift"] * frame) if drifts else pose

    key: Key = None
    if "line_delay" in effects and not recording.static:
        rows = range(effects.get("camera", bench.camera).height)
        pose = np.array([path(time + clock + row * effects["line_delay"]) for row in rows])
    else:
        pose = path(time + clock)
        if "tap_delay" not in effects:
            key = (recording.index, frame, drifts, clock)
            if recording.static:
                key = (recording.index, drifts and frame)
    return Instant(recording.index, frame, time, pose, path, key, not recording.static)


def _depth(bench: Bench, reach: Array, amplitude: Array, time: float, effects: Effects) -> Array:
    """(h, w) [m] depth of ranges, with what acts on these."""
    camera = effects.get("camera", bench.camera)
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    r, counts = reach.copy(), np.maximum(amplitude, 0.5)
    if "offset" in effects:
        r += effects["offset"]
    if "amplitude" in effects:
        size, power, reference = effects["amplitude"]
        r += size * (reference / counts) ** power
    if "gain" in effects:
        threshold, below = effects["gain"]
        r += below * (counts < threshold)
    if "delays" in effects:
        r += effects["delays"][0] * u + effects["delays"][1] * v
    if "square" in effects:
        r += effects["square"] * (r - 1.2) ** 2
    if "warming" in effects:
        r += effects["warming"] * bench.warmth(time)
    if "ripple" in effects:
        size, rate = effects["ripple"]
        r += size * np.sin(2 * np.pi * rate * time)
    if "sectors" in effects:
        size, order = effects["sectors"]
        r += size * np.sin(order * np.arctan2(v - camera.cy, u - camera.cx))
    # who made the depth of the range knew the stated camera only
    return r / np.linalg.norm(bench.directions(bench.camera), axis=-1)


def _laws(z: Array, recording: int, effects: Effects) -> Array:
    if "scale" in effects:
        z = z * (1 + effects["scale"])
    if "jump" in effects:
        first, size = effects["jump"]
        z = z + size * (recording >= first)
    if "pattern" in effects:
        z = z + effects["pattern"]
    return z


def _without_lost(bench: Bench, z: Array, amplitude: Array, effects: Effects, rng: np.random.Generator) -> Array:
    """NaN where too little or too much light came back."""
    dropout = effects.get("dropout", bench.sensor.dropout)
    if dropout:
        threshold, width = dropout
        lost = 1 / (1 + np.exp(np.clip((amplitude - threshold) / width, -50, 50)))
        z = np.where(rng.random(z.shape) < lost, np.nan, z)
    if "saturation" in effects:
        z = np.where(amplitude > effects["saturation"], np.nan, z)
    return z
