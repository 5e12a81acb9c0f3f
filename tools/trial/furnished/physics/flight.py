"""Indirect time of flight: taps of a period, their phase, the range that phases of all frequencies agree on."""

from typing import Any

import numpy as np

from tools.trial.furnished.physics.bench import Bench, Instant
from tools.trial.furnished.physics.phasors import phasors
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import C, Effects, SensorNumbers
from tools.trial.furnished.physics.world import SeenPixels


def flight(
    bench: Bench, instant: Instant, effects: Effects, noise: np.random.Generator | None
) -> tuple[Array, Array, SeenPixels]:
    """(h, w) [m] range, NaN where nothing is; (h, w) [counts] amplitude; what is seen."""
    sensor, camera = bench.sensor, effects.get("camera", bench.camera)
    n = sensor.taps
    if "tap_delay" in effects:
        delays = [(k - (n - 1) / 2) * effects["tap_delay"] for k in range(n)]
        each = [phasors(bench, instant.path(instant.time + d), effects, camera, None) for d in delays]
    else:
        each = [phasors(bench, instant.pose, effects, camera, instant.key)] * n
    # a differential pixel: the light's own level cancels, and is that of all taps
    level = np.asarray(sum(one[1] for one in each) / n)
    hits = each[n // 2][2]
    phases, amplitudes = [], []
    for i in range(len(sensor.frequencies)):
        sampled = _sampled(sensor, [one[0][i] for one in each], level, effects, noise)
        phases.append(np.angle(sampled) % (2 * np.pi))
        amplitudes.append(np.abs(sampled) / sensor.electrons)
    reach = _unfolded(sensor, phases) if len(phases) > 1 else _single(sensor, phases[0], hits, "folds" in effects)
    return np.where(np.isfinite(hits.z), reach, np.nan), np.mean(amplitudes, 0), hits


def _sampled(
    sensor: SensorNumbers, light: list[Array], level: Array, effects: Effects, noise: np.random.Generator | None
) -> Array:
    """(h, w) complex, of the taps of one frequency."""
    n = sensor.taps
    orders = {1: 1.0, **effects.get("harmonics", {})}
    ambient = effects.get("ambient", sensor.ambient)
    total: Array = np.zeros(1)
    for k in range(n):
        amplitude = np.abs(light[k]) * sensor.electrons
        phase = np.angle(light[k]) - 2 * np.pi * k / n
        wave = amplitude * sum(size * np.cos(order * phase) for order, size in orders.items())
        tap = sensor.shot * level * sensor.electrons + ambient + wave
        # the same variance in all taps: read noise and the level of the light folded in
        variance = np.maximum(sensor.shot * level * sensor.electrons + ambient, 0)
        if noise is not None:
            tap = tap + np.sqrt(variance) * noise.standard_normal(tap.shape)
        total = total + tap * np.exp(2j * np.pi * k / n)
    return total * 2 / n


def _single(sensor: SensorNumbers, phase: Array, hits: SeenPixels, folds: bool) -> Array:
    """(h, w) [m] range of one frequency, in the right period unless it folds."""
    period = C / 2 / sensor.frequencies[0]
    reach = phase / 2 / np.pi * period
    if folds:
        return reach
    near = np.nan_to_num(hits.range)
    return reach + period * np.round((near - reach) / period)


def _unfolded(sensor: SensorNumbers, phases: list[Array]) -> Array:
    """(h, w) [m] the period of the highest frequency that suits the others best; then the mean of all by f^2."""
    frequencies = sensor.frequencies
    periods = [C / 2 / f for f in frequencies]
    high = int(np.argmax(frequencies))
    first = phases[high] / 2 / np.pi * periods[high]
    best, number = np.full(first.shape, np.inf), np.zeros(first.shape)
    for n in range(int(np.ceil(sensor.range_max / periods[high]))):
        guess = first + n * periods[high]
        misfit: Any = sum(
            (np.abs(((guess / periods[i] - phases[i] / 2 / np.pi) + 0.5) % 1 - 0.5) * periods[i] * frequencies[i]) ** 2
            for i in range(len(frequencies))
            if i != high
        )
        better = misfit < best
        best[better] = misfit[better]
        number[better] = n
    first = first + number * periods[high]
    weights = np.array(frequencies) ** 2.0
    weights /= weights.sum()
    mean: Array = np.zeros(1)
    for i, weight in enumerate(weights):
        turn = phases[i] / 2 / np.pi
        turns = np.round(first / periods[i] - turn)
        mean = mean + weight * (turn + turns) * periods[i]
    return mean
