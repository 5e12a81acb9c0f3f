"""A fitted law as effects of a sensor model."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.samples import reach
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.phase.column_delay import ColumnDelay
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

NO_PHASE = np.pi / np.sqrt(3)  # [rad] standard deviation of a phase of which nothing is known
RADII = 33  # nodes of a radial table
# half an octave: on squares darker than any that were fitted a curve that goes on errs less than one that is held
BEYOND = 2**0.5
LIGHTS = 49  # nodes of a brightness curve: 15 % apart over three decades, which leaves a thousandth of it
POWERS = {"amplitude": 1.0, "amplitude^2": 2.0}
# what a calibration finds
FITTED = (
    "depth_offset", "depth_scale", "disparity_offset", "disparity_distortion", "cyclic_error", "amplitude_error",
    "column_delay", "fixed_pattern", "tabulated",
)  # fmt: skip
Values = dict[str, float]


@dataclass(frozen=True)
class LawNumbers:
    """Numbers of a law by term, their standard deviations, and what the terms need to become effects."""

    # value, std: by the term's key
    value: Values
    std: Values
    nodes: tuple[float, ...] = ()  # of a curve of straight pieces [m]
    ir_reference: float = 1000.0  # of the amplitude error [count]
    ratio: NDArray[np.floating] | None = field(default=None, repr=False)  # (h, w) of rays, see `Start`
    # least and largest amplitude seen [count]; a brightness curve is held half an octave beyond
    ir_span: tuple[float, float] = (100.0, 65535.0)


def with_law(known: Sensor, camera: Camera, numbers: LawNumbers) -> Sensor:
    """The sensor with the law's effects added to what is known of it."""
    effects: dict[str, Effect] = {}
    std: dict[tuple[str, str], float | tuple[float, ...]] = {}
    value, deviation = numbers.value, numbers.std
    if "offset" in value:
        effects["depth_offset"] = DepthOffset(value["offset"])
        std["depth_offset", "offset"] = deviation["offset"]
    if "scale" in value or numbers.ratio is not None:
        scale: Any = value.get("scale", 0.0)
        # the depth was computed along the stated rays: part of what turns a range into a depth, and exact
        old = known.effect("depth_scale")
        scale = (1 + scale) * (1 + np.asarray(old.scale)) - 1 if isinstance(old, DepthScale) else scale
        whole = scale if numbers.ratio is None else (1 + scale) * np.asarray(numbers.ratio, float) - 1
        effects["depth_scale"] = DepthScale(whole)
        std["depth_scale", "scale"] = deviation.get("scale", 0.0)
    if "disparity" in value:
        effects["disparity_offset"] = DisparityOffset(value["disparity"])
        std["disparity_offset", "offset"] = deviation["disparity"]
    _add_brightness(numbers, effects, std)
    if "delay u" in value:
        effects["column_delay"] = ColumnDelay(value["delay u"], value["delay v"])
        std["column_delay", "slope"], std["column_delay", "slope_v"] = deviation["delay u"], deviation["delay v"]
    _add_waves(numbers, effects, std)
    _add_table(numbers, camera, known, effects, std)
    sources = dict.fromkeys(effects, "")
    kept = tuple(e for e in known.effects if e.name not in effects)
    return replace(
        known,
        effects=(*kept, *effects.values()),
        std={k: v for k, v in known.std.items() if k[0] not in effects} | std,
        sources={k: v for k, v in known.sources.items() if k not in effects} | sources,
        fitted=known.fitted | effects.keys(),
        left_out=(),
    )


def waves(numbers: LawNumbers) -> list[tuple[float, float, float, float, float]]:
    """(amplitude [m], period [m], phase [rad], std of amplitude, std of phase) of each wave."""
    found = []
    for key in numbers.value:
        if key.startswith("sin "):
            period = key[4:]
            s, c = numbers.value[key], numbers.value["cos " + period]
            size = float(np.hypot(s, c))
            std = max(numbers.std[key], numbers.std["cos " + period])
            phase = float(np.arctan2(c, s)) % (2 * np.pi)
            found.append((size, float(period), phase, std, min(std / max(size, 1e-9), NO_PHASE)))
    return found


def _add_waves(numbers: LawNumbers, effects: dict, std: dict) -> None:
    found = waves(numbers)
    if found:
        size, period, phase, size_std, phase_std = (tuple(column) for column in zip(*found, strict=True))
        effects["cyclic_error"] = CyclicError(np.array(size), np.array(period), np.array(phase))
        periods = tuple(numbers.std.get(f"period {p:.6f}", 0.01 * p) for p in period)
        std["cyclic_error", "amplitude"] = size_std
        std["cyclic_error", "phase"] = phase_std
        std["cyclic_error", "period"] = periods


def _add_brightness(numbers: LawNumbers, effects: dict, std: dict) -> None:
    """One power of the darkness is an amplitude error; a curve of two shapes is a table over the amplitude."""
    value, deviation = numbers.value, numbers.std
    if "amplitude log" in value:
        low, high = numbers.ir_span
        ir = np.geomspace(low / BEYOND, high * BEYOND, LIGHTS)
        dark = numbers.ir_reference / ir
        shapes = {"amplitude^2": dark**2, "amplitude log": np.log(dark)}
        own = [key for key in shapes if key in value]
        curve = sum((value[key] * shapes[key] for key in own), np.zeros(LIGHTS))
        effects["tabulated"] = Tabulated(("amplitude",), (tuple(map(float, ir)),), curve)
        std["tabulated", "values"] = _of_sum([deviation[key] * shapes[key] for key in own])
        return
    for key, power in POWERS.items():
        if key in value:
            effects["amplitude_error"] = AmplitudeError(value[key], power, numbers.ir_reference)
            std["amplitude_error", "coefficient"] = deviation[key]


def _add_table(numbers: LawNumbers, camera: Camera, known: Sensor, effects: dict, std: dict) -> None:
    """Radial terms, or the curve of straight pieces, as a table; a sensor has one, so beside a curve they are a map."""
    value = numbers.value
    radial = [key for key in value if key.startswith("radius")]
    pieces = [key for key in value if key.startswith("curve")]
    triangulating = known.principle.triangulates
    if pieces:
        over = "range" if known.principle == Principle.TIME_OF_FLIGHT else "depth"
        # nodes beyond what was recorded have no term
        nodes = tuple(numbers.nodes[int(key.split()[1])] for key in pieces)
        effects["tabulated"] = Tabulated((over,), (nodes,), np.array([value[key] for key in pieces]))
        std["tabulated", "values"] = tuple(numbers.std[key] for key in pieces)
    mapped = radial and "tabulated" in effects
    if radial and not mapped:
        radii, bend, deviation = _radial_table(numbers, camera, radial)
        name = "values_px" if triangulating else "values"
        table: Any = {name: bend}
        effects["tabulated"] = Tabulated(("radius",), (radii,), **table)
        std["tabulated", name] = deviation
    field, deviations = _linear(numbers, camera), [numbers.std[key] for key in value if key.startswith("tilt")]
    if mapped:
        radii, bend, deviation = _radial_table(numbers, camera, radial)
        field = field + np.interp(np.asarray(View(camera).radius, float), radii, bend)
        deviations.append(max(deviation))
    if deviations:
        effect = DisparityDistortion(map=field) if triangulating else FixedPattern(map=field)
        effects[effect.name] = effect
        std[effect.name, "map"] = float(np.linalg.norm(deviations))


def _linear(numbers: LawNumbers, camera: Camera) -> NDArray[np.float64]:
    """(h, w) [px] disparity of a pattern that lies askew."""
    across, down = (numbers.value.get(key, 0.0) / reach(camera) for key in ("tilt u", "tilt v"))
    v, u = np.mgrid[: camera.height, : camera.width]
    return np.asarray(across * (u - camera.cx) + down * (v - camera.cy))


def _radial_table(
    numbers: LawNumbers, camera: Camera, radial: list[str]
) -> tuple[tuple[float, ...], NDArray[np.floating], tuple[float, ...]]:
    """Radii [px], values and standard deviations of the radial terms together."""
    corners = np.array([[0, 0], [camera.width - 1, 0], [0, camera.height - 1], [camera.width - 1, camera.height - 1]])
    largest = float(np.hypot(corners[:, 0] - camera.cx, corners[:, 1] - camera.cy).max())
    radii = np.linspace(0, max(largest, 1.0), RADII)
    share = radii / reach(camera)
    bend = sum((numbers.value[key] * share ** int(key[-1]) for key in radial), np.zeros(RADII))
    return tuple(map(float, radii)), bend, _of_sum([numbers.std[key] * share ** int(key[-1]) for key in radial])


def _of_sum(parts: list[NDArray[np.floating]]) -> tuple[float, ...]:
    """Standard deviations of a sum of shapes; that their numbers are correlated is left out."""
    return tuple(float(x) for x in np.sqrt(sum(np.square(part) for part in parts)))
