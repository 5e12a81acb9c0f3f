"""Two sensor models side by side, or a model and a recording of a scene that stands still."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.loss import DEPTHS, stated
from fusion.simulation.exporting.target import Floats
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.view import view_of_ideal
from fusion.simulation.rendering.light_level import with_light_level

MOST_FRAMES = 60  # of a recording: a spread to 9 %, for each of many pixels
FEWEST_FRAMES, FEWEST_PIXELS = 5, 200
BINS = 8  # of the depths that a recording holds


@dataclass(frozen=True)
class ComparedSide:
    """What one side says at each depth (n,) [m]; NaN where it says nothing."""

    name: str
    bias: Floats
    sigma: Floats
    missing: Floats


@dataclass(frozen=True)
class SensorComparison:
    """Two sides over the same depths.

    Attributes:
        depths: (n,) [m].
        one, other: the sides.
        apart: (n,) [m] root of (difference of the mean errors)^2 + (difference of the spreads)^2 over the image.
        parameters: effect.parameter to the values of both, None where one has no such effect; empty for a recording.
        notes: what cannot be compared, one sentence each.
    """

    depths: Floats
    one: ComparedSide
    other: ComparedSide
    apart: Floats
    parameters: dict[str, tuple[float | None, float | None]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        apart = ", ".join(f"{1e3 * value:.1f}" for value in self.apart)
        return f"<{self.one.name} and {self.other.name}: {apart} mm apart>"


def compare_sensors(one: Sensor, other: Sensor, camera: Camera) -> SensorComparison:
    """Two models before frontal white walls, seen by one camera.

    >>> one, other = fusion.read_sensor("kinect-v1"), fusion.read_sensor("azure-kinect")
    >>> found = fusion.compare_sensors(one, other, fusion.find_camera("kinect-v1"))
    >>> bool((found.one.sigma[found.depths > 2] > found.other.sigma[found.depths > 2]).all())
    True
    """
    first, second = stated(one, camera), stated(other, camera)
    apart = np.sqrt(_mean((first.bias - second.bias) ** 2 + (first.sigma - second.sigma) ** 2))
    sides = [
        ComparedSide(model.name, said.mean_bias, said.rms_sigma, np.isnan(said.bias).mean(axis=1))
        for model, said in ((one, first), (other, second))
    ]
    return SensorComparison(np.array(DEPTHS), sides[0], sides[1], apart, _side_by_side(one, other))


def compare_recording(sensor: Sensor, recording: Recording) -> SensorComparison:
    """A model and a recording in which nothing moves: spread and missing values by depth; of the mean nothing is known.

    Raises:
        RecordingError: too few frames, or too few pixels that show anything.
    """
    count = min(len(recording), MOST_FRAMES)
    if count < FEWEST_FRAMES:
        raise RecordingError("too few frames tell no spread", recording.path, count, f"{FEWEST_FRAMES} or more")
    depths = np.stack([recording[index].depth for index in each(range(count), "reading")])
    known = np.isfinite(depths)
    total = known.sum(axis=0)
    mean = np.where(total > 0, np.nansum(depths, axis=0) / np.maximum(total, 1), np.nan).astype(np.float32)
    squares = np.nansum((depths - mean) ** 2, axis=0)
    seen = total >= max(2, count // 2)
    if seen.sum() < FEWEST_PIXELS:
        expected = f"{FEWEST_PIXELS} or more"
        raise RecordingError("too few pixels show anything", recording.path, int(seen.sum()), expected)
    spread = np.where(seen, np.sqrt(squares / np.maximum(total - 1, 1)), np.nan)
    said, lost = _said(with_light_level(sensor), recording.camera, mean)
    return _by_depth(sensor, recording, (mean, seen), (said, lost), (spread, 1 - total / count))


def _said(sensor: Sensor, camera: Camera, mean: Floats) -> tuple[Floats, Floats]:
    """Spread (h, w) [m] and share of missing values that the model says of these surfaces."""
    view = view_of_ideal(IdealFrame(mean, rounding=1 / camera.depth_scale), camera, sensor)
    with np.errstate(all="ignore"):
        _, sigma = sensor.repeated(mean, view)
        return sigma, np.broadcast_to(sensor.dropout(mean, view), mean.shape)


def _by_depth(
    sensor: Sensor,
    recording: Recording,
    surface: tuple[Floats, Floats],
    said: tuple[Floats, Floats],
    measured: tuple[Floats, Floats],
) -> SensorComparison:
    """Medians over pixels of like depth: moving things and edges are few."""
    mean, seen = surface
    edges = np.quantile(mean[seen], np.linspace(0, 1, BINS + 1))
    rows = []
    for low, high in pairwise(edges):
        inside = seen & (mean >= low) & (mean <= high) & np.isfinite(said[0])
        if inside.sum() < FEWEST_PIXELS // BINS:
            continue
        both = [float(np.median(mean[inside])), *(float(np.median(part[0][inside])) for part in (said, measured))]
        rows.append([*both, *(float(np.mean(part[1][inside])) for part in (said, measured))])
    table = np.array(rows, float).reshape(-1, 5)
    nothing = np.full(len(table), np.nan)
    own = ComparedSide(sensor.name, nothing, table[:, 1], table[:, 3])
    other = ComparedSide(str(recording.path.name), nothing, table[:, 2], table[:, 4])
    notes = ("the mean error of a recording is not known without the truth: fusion explain tells it of a known scene",)
    return SensorComparison(table[:, 0], own, other, np.abs(table[:, 1] - table[:, 2]), {}, notes)


def _side_by_side(one: Sensor, other: Sensor) -> dict[str, tuple[float | None, float | None]]:
    found: dict[str, list[float | None]] = {}
    for place, sensor in enumerate((one, other)):
        for effect in sensor.effects:
            for name in parameters(effect):
                value = np.asarray(getattr(effect, name), float)
                pair = found.setdefault(f"{effect.name}.{name}", [None, None])
                pair[place] = float(value) if value.ndim == 0 else float(np.sqrt(np.mean(value**2)))
    return {name: (a, b) for name, (a, b) in found.items() if a or b}


def _mean(values: Floats) -> Floats:
    count = np.isfinite(values).sum(axis=1)
    return np.where(count > 0, np.nansum(values, axis=1) / np.maximum(count, 1), np.nan)
