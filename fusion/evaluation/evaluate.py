"""The sensor bench: still recordings in, statistics, bias, noise, shares, steps and drift out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fusion.calibration.depth.known import start
from fusion.calibration.noise.target_noise import TargetNoise, measure_target
from fusion.calibration.stretches import Stretch, still_stretches
from fusion.errors import FusionError
from fusion.evaluation.bias import Bias, bias_of
from fusion.evaluation.light import ambient_light
from fusion.evaluation.near_limit import SurfaceSeen, near_limits
from fusion.evaluation.notes import notes_on
from fusion.evaluation.quantization import quantization_of
from fusion.evaluation.still.drift import Drift, drift_of, nothing_told
from fusion.evaluation.still.shares import brightness_of, joined, shares_over, tiles_of
from fusion.evaluation.still.statistics import Still, StretchSample, measure_still, sample_of
from fusion.evaluation.stretch_look import StretchLook
from fusion.evaluation.summary import Evaluation
from fusion.evaluation.surface import ExpectedSurface, expected_depth, surface_of
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.quantity import DISTANCE_STD as POSSIBLE_STD
from fusion.recording.checks.stamps import unit_of_stamps
from fusion.recording.native.scene_file import stated_scene
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor

VARIABLES = ("depth", "incidence", "brightness")
DISTANCE_STD = 0.001  # [m] of a stated distance: what makers of laser distance meters promise


@dataclass(frozen=True)
class EvaluationSettings:
    """What an evaluation may be told.

    Attributes:
        sensor: a model to compare with: its noise, and the bias that it leaves.
        pixel: (u, v) whose series is shown; None takes the centre.
        distance_std: standard deviation of the stated distances [m].
        force: take recordings or models of another camera.
    """

    sensor: Sensor | None = None
    pixel: tuple[int, int] | None = None
    distance_std: float = DISTANCE_STD
    force: bool = False

    def __post_init__(self) -> None:
        POSSIBLE_STD.check(self.distance_std)


def evaluate(recordings: Sequence[Recording], settings: EvaluationSettings | None = None) -> Evaluation:
    """Measure what a camera does in front of still scenes.

    Args:
        recordings: of one camera; each is split where something is moved.
        settings: sensor model, pixel and so on.
    Raises:
        FusionError: no recording, nothing still, no depth, recordings of different cameras.

    >>> bench = fusion.evaluate([fusion.open_recording(f"wall_{i}") for i in range(5)])
    >>> len(bench.looks)
    5
    """
    settings = settings or EvaluationSettings()
    if not recordings:
        raise FusionError("no recording", found=0, expected="one or more recordings of a camera that stands still")
    camera = start(recordings, None, settings.sensor, settings.force).camera
    parts = [still_stretches(recording) for recording in each(recordings, "finding what stands still")]
    stretches = [stretch for some in parts for stretch in some]
    looks = [look_at(stretch, camera, settings) for stretch in each(stretches, "measuring")]
    tiles = joined([look.tiles for look in looks])
    shares = {name: found for name in VARIABLES if (found := shares_over(tiles, name)) is not None}
    ambient = ambient_light([look.noise for look in looks if look.noise is not None], camera, settings.sensor)
    return Evaluation(
        camera,
        looks,
        shares,
        near_limits(_seen(looks)),
        quantization_of([look.still.levels for look in looks], camera.depth_scale),
        ambient,
        notes_on(looks, recordings),
        settings.sensor,
    )


def look_at(stretch: Stretch, camera: Camera, settings: EvaluationSettings) -> StretchLook:
    """Everything that one stretch says."""
    sample = sample_of(stretch)
    surface = surface_of(sample, camera)
    u, v = settings.pixel or (camera.width // 2, camera.height // 2)
    still = measure_still(sample, expected_depth(surface, sample.reference.depth), (v, u))
    usual = np.asarray(sample.reference.depth, float)
    bias = bias_of(still, usual, surface, camera, settings.sensor, settings.distance_std)
    noise = _noise(sample, surface, camera)
    tiles = tiles_of(still, surface)
    stated = stated_scene(stretch.recording).reflectance
    counts = np.array([part.sum() for part in (tiles.valid, tiles.missing, tiles.outliers)])
    shares = counts / counts.sum() if counts.sum() else np.full(3, np.nan)
    return StretchLook(
        stretch,
        still,
        surface,
        bias,
        noise,
        _expected(noise, still, settings.sensor, camera),
        _drift(still, bias),
        quantization_of([still.levels], camera.depth_scale),
        float("nan") if stated is None else stated,
        tiles,
        *map(float, shares),
    )


def _drift(still: Still, bias: Bias | None) -> Drift:
    """Of the centre, where it is of the surface and the time stamps are seconds."""
    if bias is not None and bias.beside:
        return nothing_told(still.time, still.centre, f"Nothing is told of warming up: {bias.stands()}.")
    for wrong in unit_of_stamps(still.time):
        return nothing_told(still.time, still.centre, f"Nothing is told of warming up: {wrong.seen}; {wrong.do}.")
    return drift_of(still.time, still.centre)


def _noise(sample: StretchSample, surface: ExpectedSurface, camera: Camera) -> TargetNoise | None:
    """Axial and lateral noise of the target, from the frames that are held anyway."""
    if surface.target is None or len(sample.frames) < 2:
        return None
    return measure_target(sample.quiet(), camera, surface.target)


def _expected(noise: TargetNoise | None, still: Still, sensor: Sensor | None, camera: Camera) -> float:
    """What the model says of the noise at the target's middle [m]."""
    if noise is None or sensor is None:
        return float("nan")
    if not any(effect.changes("noise") for effect in sensor.effects):
        return float("nan")  # a model of errors alone says nothing of noise
    flat = np.full(camera.shape, noise.depth, np.float32)
    ir = None if still.ir is None else np.nan_to_num(still.ir.mean)
    return float(sensor.sigma(flat, np.full(camera.shape, noise.tilt, np.float32), camera, ir)[noise.pixel])


def _seen(looks: list[StretchLook]) -> list[SurfaceSeen]:
    """The stretches as points of valid share over distance; brightness by stated reflectance where all state it."""
    stated = all(np.isfinite(look.reflectance) for look in looks)
    return [
        SurfaceSeen(look.surface.distance, look.valid, look.reflectance if stated else _brightness(look))
        for look in looks
    ]


def _brightness(look: StretchLook) -> float:
    """Median brightness of the region, taken to 1 m: light falls with the distance squared."""
    light = brightness_of(look.still)[look.surface.region]
    light = light[np.isfinite(light)]
    return float(np.median(light)) * look.surface.distance**2 if light.size else float("nan")
