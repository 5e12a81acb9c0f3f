"""Laws that a catalogue has, written from the physics of the raw signal; some with a form that no textbook gives."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, zoom

from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.second_bounce import second_bounce
from tools.trial.concealed.shot import Place

Array = NDArray[np.float64]
Rng = np.random.Generator


def cyclic_error(rng: Rng) -> Law:
    """Harmonics of the correlation; orders 2, 4, 5 fold onto the first of three samples."""
    shifted = bool(rng.random() < 0.4)
    orders = [2, 4, 5] if shifted else [int(rng.choice([2, 4]))]
    parts = [(k, 0.01 / (i + 1), rng.uniform(0, 2 * np.pi, 3)) for i, k in enumerate(orders)]
    return Law("cyclic_error", "harmonic", lambda place: parts, ("depth",), shifted=shifted, accept=("cyclic_error",))


def amplitude_error(rng: Rng) -> Law:
    power = float(rng.choice([1.0, 0.8, 0.5]))
    return Law(
        "amplitude_error",
        "delay",
        lambda p: 1e-3 * (1000.0 / np.maximum(p.amplitude, 20.0)) ** power,
        ("amplitude", "reflectance"),
        shifted=power != 1.0,
        parameter=("coefficient", 1e-3) if power == 1.0 else None,
    )


def column_delay(rng: Rng) -> Law:
    return Law("column_delay", "delay", lambda p: 1e-5 * (p.u - p.shot.camera.cx), ("u",), parameter=("slope", 1e-5))


def emitter_parallax(rng: Rng) -> Law:
    side = float(rng.choice([-1, 1]))
    return Law("emitter_parallax", "delay", lambda p: _longer(p, 0.02 * side), ("u", "depth"))


def _longer(p: Place, apart: float) -> Array:
    """How much longer the way is when the lamp stands `apart` metres beside the lens."""
    X = p.shot.camera.rays() * p.z[..., None]
    return np.asarray((np.linalg.norm(X - np.array([apart, 0, 0]), axis=-1) - np.linalg.norm(X, axis=-1)) / 2)


def fixed_pattern(rng: Rng) -> Law:
    seed = int(rng.integers(2**31))
    return Law("fixed_pattern", "delay", lambda p: 1e-3 * _map(seed, p, 6.0, 0.5), ("u", "v"))


def _map(seed: int, p: Place, smooth_px: float, rough: float) -> Array:
    own = np.random.default_rng(seed)
    field = gaussian_filter(own.standard_normal(p.z.shape), smooth_px, mode="wrap")
    return field / field.std() + rough * own.standard_normal(p.z.shape)


def stray_light(rng: Rng) -> Law:
    shifted = bool(rng.random() < 0.5)
    widths = ((6.0, 0.3), (16.0, 0.4), (40.0, 0.3)) if shifted else ((30.0, 1.0),)

    def acts(p: Place, light: NDArray[np.complex128], modulations: Array) -> NDArray[np.complex128]:
        out = -light
        for width, share in widths:
            for i, one in enumerate(light):
                out[i] += share * (_spread(one.real, width) + 1j * _spread(one.imag, width))
        return 0.01 * out

    known = None if shifted else ("fraction", 0.01)
    return Law("stray_light", "light", acts, ("amplitude", "neighbours"), shifted=shifted, parameter=known)


def _spread(image: Array, width: float) -> Array:
    """Gaussian spread, by way of squares of 4 px: far finer than the spread itself."""
    h, w = image.shape
    small = image.reshape(h // 4, 4, w // 4, 4).mean(axis=(1, 3))
    return zoom(
        gaussian_filter(small, width / 4, mode="constant", truncate=3.0), 4, order=1, grid_mode=True, mode="nearest"
    )


def multipath(rng: Rng) -> Law:
    return Law("multipath", "light", lambda p, light, f: second_bounce(p.shot, light, f), ("neighbours",))


def warm(rng: Rng, stage: str, unit: float) -> Law:
    """By the logged temperature; or with two time constants of its own, which the log follows only roughly."""
    shifted = bool(rng.random() < 0.4)

    def acts(p: Place) -> Array:
        if shifted:
            rise = 0.6 * (1 - np.exp(-p.time / 400.0)) + 0.4 * (1 - np.exp(-p.time / 1500.0))
            return unit * (12.0 * rise) * np.ones(p.z.shape)
        return unit * (p.temperature - 24.0) * np.ones(p.z.shape)

    known = None if shifted else ("coefficient", unit)
    return Law("temperature_drift", stage, acts, ("time", "temperature"), shifted=shifted, parameter=known)


def vertical_banding(rng: Rng) -> Law:
    edges, steps = np.sort(rng.uniform(0.05, 0.95, 7)), rng.choice([-1.0, 1.0], 7) * rng.uniform(0.7, 1.3, 7)

    def acts(p: Place) -> Array:
        level = np.concatenate([[0.0], np.cumsum(steps)])
        level -= level.mean()
        return 0.01 * level[np.searchsorted(edges, p.u / p.shot.camera.width)]

    return Law("vertical_banding", "disparity", acts, ("u",))


def pixel_locking(rng: Rng) -> Law:
    """What a parabola through three costs makes of a dot whose correlation is not one."""
    power, period = float(rng.uniform(1.2, 1.7)), 1.0

    def acts(p: Place) -> Array:
        f = np.mod(p.shot.camera.f * 0.075 / p.z / period + 0.5, 1.0) - 0.5
        left, middle, right = (np.abs(f - k) ** power for k in (-1.0, 0.0, 1.0))
        return 0.5 * (period * 0.5 * (left - right) / (left - 2 * middle + right) - f)

    return Law("pixel_locking", "disparity", acts, ("disparity", "depth"), shifted=True)


def disparity_distortion(rng: Rng) -> Law:
    c, decay = rng.standard_normal(6), float(rng.choice([0.0, 0.03]))

    def acts(p: Place) -> Array:
        x, y, d = p.x, p.y, p.shot.camera.f * 0.075 / p.z
        bowl = c[0] * (x * x - 0.3) + c[1] * (y * y - 0.2) + c[2] * x * y * 2 + c[3] * (x**3 - 0.6 * x) * 2
        return 0.01 * (bowl + c[4] * np.cos(3 * x + c[5])) * np.exp(-decay * d)

    return Law("disparity_distortion", "disparity", acts, ("u", "v"), shifted=True)


FLIGHT: dict[str, Callable[[Rng], Law]] = {
    "cyclic_error": cyclic_error,
    "amplitude_error": amplitude_error,
    "column_delay": column_delay,
    "emitter_parallax": emitter_parallax,
    "fixed_pattern": fixed_pattern,
    "stray_light": stray_light,
    "multipath": multipath,
    "temperature_drift": lambda rng: warm(rng, "delay", 3e-4),
    "depth_offset": lambda rng: Law(
        "depth_offset", "delay", lambda p: 1e-3 * np.ones(p.z.shape), (), parameter=("offset", 1e-3)
    ),
    "depth_scale": lambda rng: Law("depth_scale", "delay", lambda p: 1e-3 * p.r, ("depth",), parameter=("scale", 1e-3)),
}
MATCHING: dict[str, Callable[[Rng], Law]] = {
    "disparity_offset": lambda rng: Law(
        "disparity_offset", "disparity", lambda p: 0.01 * np.ones(p.z.shape), ("depth",), parameter=("offset", 0.01)
    ),
    "depth_scale": lambda rng: Law(
        "depth_scale",
        "disparity",
        lambda p: -1e-3 * p.shot.camera.f * 0.075 / p.z,
        ("depth",),
        parameter=("scale", 1e-3),
    ),
    "disparity_distortion": disparity_distortion,
    "vertical_banding": vertical_banding,
    "pixel_locking": pixel_locking,
    "temperature_drift": lambda rng: warm(rng, "disparity", 1e-3),
}
