"""Ambient light estimated from the noise of simulated targets: how often the 90 % interval holds the light put in.

    python -m tools.reproduce.calibration.ambient_light [--seeds 10] [--frames 30] [--places 4] [--json FILE]

Each recording is made by a Kinect v2 of its own (its noise differs by 5 %, normal, from that of its kind) at a light
between the presets' three. The noise law between them is taken as known, up to the light in which the paper measured:
1 to 12 klx under clouds and 85 to 95 klx in the sun, drawn anew for each recording. The last lines take the presets as
they are, and the simulator's own ambient_light effect on the indoor preset, which is nearer to the
paper's law in the sun than beyond 1 m under clouds.
"""

import argparse
import json
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fusion.calibration.noise.ambient import AmbientEstimate, estimate_ambient, points_of
from fusion.calibration.noise.laws.light_law import OVERCAST, ROOM_LUX, SUN, effective, light_law
from fusion.calibration.noise.poses import Pose
from fusion.errors import FusionError
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from tools.reproduce.calibration.noise import CAMERAS, NOISE, measured, seen_at, simulated

CAMERA = CAMERAS["v2"]
PLACES = ((0.8, 0.0), (1.0, 45.0), (1.2, 60.0), (1.0, 0.0), (1.3, 30.0), (1.6, 15.0))  # [m], [deg]
LIGHTS = (ROOM_LUX, 1e3, 2e3, 4e3, 8e3, 16e3, 32e3, 64e3)
UNIT = 0.05
COVERED = (0.85, 0.95)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--places", type=int, default=4, help="poses of the target, up to 6")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    results: dict[str, Any] = {}
    hits: list[bool] = []
    hits_noise: list[bool] = []
    for lux in LIGHTS:
        found, nominal = zip(*(one(lux, seed, options) for seed in range(options.seeds)), strict=True)
        inside = [e.low <= lux <= e.high for e in found]
        by_noise = [e.noise_low <= n <= e.noise_high for e, n in zip(found, nominal, strict=True)]
        hits, hits_noise = hits + inside, hits_noise + by_noise
        print(f"  {lux:7.0f} lux: {shown(found)}; held by {np.mean(inside):.2f} (noise alone: {np.mean(by_noise):.2f})")
        results[f"{lux:.0f}"] = {"covered": float(np.mean(inside)), "noise_alone": float(np.mean(by_noise))}
    print(f"{np.mean(hits):.3f} of {len(hits)} intervals hold the light, {np.mean(hits_noise):.3f} were the laws' own "
          "light known (asked 0.85-0.95)")  # fmt: skip
    for name in ("indoors", "overcast", "sunlight"):
        print(f"  preset {name}: {shown([of_sensor(preset(f'kinect-v2-{name}'), s, options) for s in range(3)])}")
    for lux in LIGHTS[1:7]:
        sensor = preset("kinect-v2-indoors").having(AmbientLight(ambient=lux - ROOM_LUX))
        print(f"  effect ambient_light, {lux:.0f} lux: {shown([of_sensor(sensor, s, options) for s in range(3)])}")
    if options.json:
        options.json.write_text(json.dumps(results | {"covered": float(np.mean(hits))}, indent=1) + "\n")
    return 0 if COVERED[0] <= np.mean(hits) else 1


def one(lux: float, seed: int, options: argparse.Namespace) -> tuple[AmbientEstimate, float]:
    """An estimate, and the light at which the nominal law has the noise that was put in."""
    rng = np.random.default_rng([seed, round(lux)])
    law = light_law(None, CAMERA)
    assert law is not None
    nominal = nominal_light(lux, float(np.exp(rng.uniform(*np.log(OVERCAST[1:])))), float(rng.uniform(*SUN[1:])))
    factor = float(np.exp(UNIT * rng.standard_normal()))
    base = preset("kinect-v2-indoors")
    poses = []
    for place in PLACES[: options.places]:
        view = seen_at(CAMERA, place, None, int(rng.integers(2)))
        assert view.depth is not None and view.incidence is not None
        # the law at every pixel, as a map of constants
        sigma = np.sqrt(law.variance(view.depth.ravel(), view.incidence.ravel(), nominal)).reshape(view.depth.shape)
        sensor = base.having(AxialNoise(c0=factor * np.nan_to_num(sigma)))
        poses.append(measured(sensor, view, without_noise(base), (options.frames, rng), str(place)))
    return estimated(poses), nominal


def nominal_light(lux: float, clouds: float, sun: float) -> float:
    """The light [lux] at which the nominal law says what it does at `lux` when the paper's own lights were these."""
    light, low, grey, bright, middle, high = (float(effective(np.asarray(x))) for x in
                                              (lux, ROOM_LUX, clouds, sun, OVERCAST[0], SUN[0]))  # fmt: skip
    if light <= grey:
        at = low + (light - low) / (grey - low) * (middle - low)
    else:
        at = middle + (light - grey) / (bright - grey) * (high - middle)
    lights = np.geomspace(10.0, 2e5, 4000)
    return float(np.interp(at, effective(lights), lights))


def of_sensor(sensor: Sensor, seed: int, options: argparse.Namespace) -> AmbientEstimate:
    """The estimate from targets before this sensor."""
    rng = np.random.default_rng(seed)
    poses = []
    for place in PLACES[: options.places]:
        with suppress(FusionError):  # nearly all pixels are missing
            poses.append(simulated(sensor, CAMERA, without_noise(sensor), place, (options.frames, rng)))
    return estimated(poses)


def without_noise(sensor: Sensor) -> Sensor:
    """What is known of the unit: its depth errors."""
    names = (*NOISE, "ambient_light")
    return replace(sensor, effects=tuple(e for e in sensor.effects if e.name not in names), std={}, left_out=())


def estimated(poses: list[Pose]) -> AmbientEstimate:
    """The estimate from these poses; where none shows a target, nothing is known."""
    if not poses:
        return AmbientEstimate(float("nan"), 0.0, float("inf"), 0.0, float("inf"), 0, "", "no target was seen")
    found = estimate_ambient(points_of(poses), CAMERA)
    assert found is not None
    return found


def shown(found: list[AmbientEstimate] | tuple[AmbientEstimate, ...]) -> str:
    """Medians as text."""
    low, lux, high = np.median([(e.low, e.lux, e.high) for e in found], axis=0)
    return f"estimate {lux:.0f} ({low:.0f} to {high:.0f})"


if __name__ == "__main__":
    sys.exit(main())
