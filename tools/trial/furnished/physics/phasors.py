"""Light that comes back to each pixel, as a complex number for each frequency."""

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from tools.trial.furnished.physics.bench import Bench, Key
from tools.trial.furnished.physics.bounce import bounced
from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import C, Effects
from tools.trial.furnished.physics.world import SeenPixels


def phasors(
    bench: Bench, T: Array, effects: Effects, camera: StatedCamera, key: Key
) -> tuple[Array, Array, SeenPixels]:
    """(frequencies, h, w) [counts] complex; (h, w) [counts] level of the light; what the pixels' centres see."""
    light, level, middle = _collected(bench, T, effects, camera, key)
    if "bounces" in effects:
        more, more_level = bounced(bench, T, middle, effects["bounces"], key)
        light, level = light + more, level + more_level
    if "stray" in effects:
        share, width = effects["stray"]
        light = np.array([(1 - share) * x + share * _blurred(x, width, "constant") for x in light])
        level = (1 - share) * level + share * gaussian_filter(level, width, mode="constant")
    if "ghost" in effects:
        light = light + effects["ghost"] * light[:, ::-1, ::-1]
        level = level + effects["ghost"] * level[::-1, ::-1]
    if "crosstalk" in effects:
        kernel = np.array([[0.5, 1, 0.5], [1, 0, 1], [0.5, 1, 0.5]]) / 6 * effects["crosstalk"]
        kernel[1, 1] = 1 - effects["crosstalk"]
        light = np.array([_spread(x.real, kernel) + 1j * _spread(x.imag, kernel) for x in light])
        level = _spread(level, kernel)
    if "defocus" in effects:
        width = effects["defocus"]
        light = np.array([_blurred(x, width, "reflect") for x in light])
        level = gaussian_filter(level, width)
    return light, level, middle


def _collected(
    bench: Bench, T: Array, effects: Effects, camera: StatedCamera, key: Key
) -> tuple[Array, Array, SeenPixels]:
    """The light of a pixel's whole area, where it collects over one, or of its centre's ray."""
    fill, n = effects.get("fill", bench.sensor.fill), 1
    middle = bench.cast(T, camera, key=key)
    shifts = np.zeros(1)
    if fill:
        n = bench.sensor.parts
        shifts = ((np.arange(n) + 0.5) / n - 0.5) * np.sqrt(fill)
    light: Array = np.zeros(1)
    level: Array = np.zeros(1)
    for du in shifts:
        for dv in shifts:
            hits = middle if n == 1 else bench.cast(T, camera, du, dv, key)
            amplitude, path = _returned(bench, hits, effects)
            waves = [amplitude * np.exp(4j * np.pi * f * path / C) for f in bench.sensor.frequencies]
            light = light + np.array(waves) / n**2
            level = level + amplitude / n**2
    return light, level, middle


def _returned(bench: Bench, hits: SeenPixels, effects: Effects) -> tuple[Array, Array]:
    """(h, w) [counts] amplitude and (h, w) [m] half the way of the light along each ray."""
    sensor, reach = bench.sensor, np.nan_to_num(hits.range, nan=1e3)
    lamp = (1 / hits.stretch) ** sensor.falloff
    seen = np.isfinite(hits.range)
    amplitude = sensor.counts * hits.reflectance * hits.cosine * lamp / np.maximum(reach, 0.05) ** 2 * seen
    path = reach.copy()
    if "lamp_at" in effects:
        from_lamp = hits.direction * (reach / hits.stretch)[..., None] - np.array([effects["lamp_at"], 0, 0])
        path = (reach + np.linalg.norm(from_lamp, axis=-1)) / 2
    if "glass" in effects:
        thickness, index = effects["glass"]
        cosine = 1 / hits.stretch
        path = path + thickness * (np.sqrt(index**2 - 1 + cosine**2) - cosine)
    if "penetration" in effects:
        path = path + effects["penetration"] * (1 / np.maximum(hits.cosine, 0.2) - 1)
    if "inside" in effects:
        parts, inside = effects["inside"]
        path = path + inside * np.isin(hits.part, parts)
    return amplitude, path


def _blurred(wave: Array, width: float, mode: str) -> Array:
    real, imaginary = (gaussian_filter(x, width, mode=mode) for x in (wave.real, wave.imag))
    return np.asarray(real + 1j * imaginary)


def _spread(image: Array, kernel: Array) -> Array:
    return cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_REFLECT)
