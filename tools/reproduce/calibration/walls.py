"""Walls simulated for Kinect v1 and v2, calibrated as `fusion calibrate depth` does, against the curve put in.

    python -m tools.reproduce.calibration.walls [--seeds 10] [--frames 100] [--only v1 v2] [--json FILE]

Each seed is another unit (its own depth error), other walls (distance, tilt) and other laser errors (0.7 mm). The
images are the middle of the sensor's, to save time: what is measured here is the curve on the axis.

Beside each error stands the least that these laser errors allow: that of a fit which is told the form of the law, and
to which only the distances are wrong. Where that is above what was asked, no calibration can reach it.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.calibration import DepthCalibration, calibrate_walls
from fusion.calibration.depth.known import Start
from fusion.calibration.depth.maps.curve import POINTS
from fusion.calibration.depth.walls.plane import WallPlane
from fusion.calibration.depth.walls.wall import Means, Wall, wall_of
from fusion.calibration.series import PixelSeries
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, incidence_of

WIDTH, HEIGHT = 128, 96
CAMERAS = {
    "v1": Camera(WIDTH, HEIGHT, 585.0, 585.0, 63.5, 47.5, principle=Principle.STRUCTURED_LIGHT),
    "v2": Camera(WIDTH, HEIGHT, 365.0, 365.0, 63.5, 47.5, principle=Principle.TIME_OF_FLIGHT),
}
LASER = 0.0007  # [m]
DISTANCES = np.arange(0.6, 3.21, 0.1)
TILT = 0.03  # [rad] how far from frontal a careful person puts a wall: guess
WHITE = 0.8
# what only the distances tell: form of the law over z (v2's waves show within the walls, its offset does not)
TOLD: dict[str, tuple[Callable[[NDArray], NDArray], ...]] = {"v1": (lambda z: z**2, lambda z: z), "v2": (np.ones_like,)}
# the figures: rms [m] from 0.7 to 2 m, share of the distance to 3 m, coverage of the 90 % intervals
NEAR_RMS, FAR_SHARE, COVERED = 0.0003, 0.001, (0.85, 0.95)


@dataclass(frozen=True)
class Outcome:
    """One seed: rms of the curve's error near [m] and its limit, largest over distance, covered share, the law."""

    near: float
    limit: float
    far: float
    covered: float
    law: str


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--only", nargs="*", default=["v1", "v2"], choices=("v1", "v2"))
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    results, good = {}, True
    for kind in options.only:
        found = [outcome(kind, seed, options.frames) for seed in range(options.seeds)]
        for seed, one in enumerate(found):
            print(f"  {kind} seed {seed}: 0.7-2 m {one.near * 1e3:.3f} mm rms (limit {one.limit * 1e3:.3f}), "
                  f"to 3 m {one.far * 100:.3f} %, "
                  f"covered {one.covered:.2f}  {one.law}")  # fmt: skip
        near, far = [one.near for one in found], [one.far for one in found]
        covered = float(np.mean([one.covered for one in found]))
        pooled = float(np.sqrt(np.mean(np.square(near))))
        fine = pooled <= NEAR_RMS and float(np.median(far)) <= FAR_SHARE and COVERED[0] <= covered <= COVERED[1]
        good &= fine
        limits = [one.limit for one in found]
        print(
            f"{kind}: {pooled * 1e3:.3f} mm rms over all seeds (worst {max(near) * 1e3:.3f}, asked 0.3), "
            f"limit {float(np.sqrt(np.mean(np.square(limits)))) * 1e3:.3f} (worst {max(limits) * 1e3:.3f}), "
            f"{100 * float(np.median(far)):.3f} % median (worst {100 * max(far):.3f}, asked 0.1), "
            f"covered {covered:.3f} (asked 0.85-0.95){'' if fine else '  !'}"
        )
        laws = [one.law for one in found]
        results[kind] = {"rms_m": near, "limit_m": limits, "far_share": far, "covered": covered, "laws": laws}
    if options.json:
        options.json.write_text(json.dumps(results, indent=1) + "\n")
    return 0 if good else 1


def outcome(kind: str, seed: int, frames: int) -> Outcome:
    """Simulate, calibrate, compare."""
    rng = np.random.default_rng([seed, len(kind), ord(kind[1])])
    sensor, camera = unit(kind, rng), CAMERAS[kind]
    known = replace(sensor, effects=(), std={}, sources={}, left_out=())
    drawn = [simulated(sensor, camera, known, float(z), (frames, rng)) for z in DISTANCES]
    walls = [wall for wall, _ in drawn]
    found = calibrate_walls(walls, Start(camera, known, known, None, "", "", ()), surface=False)
    return judged(found, sensor, camera, limit(kind, np.array([truth for _, truth in drawn]), walls))


def limit(kind: str, true: NDArray, walls: list[Wall]) -> float:
    """Rms error [m] near of a curve of the right form that is fitted to the errors of the stated distances alone."""
    z = np.linspace(0.7, 2.0, POINTS)
    numbers = np.linalg.lstsq(_columns(kind, true), np.array([w.distance for w in walls]) - true, rcond=None)[0]
    return float(np.sqrt(np.mean((_columns(kind, z) @ numbers) ** 2)))


def _columns(kind: str, z: NDArray) -> NDArray:
    return np.column_stack([form(z) for form in TOLD[kind]])


def unit(kind: str, rng: np.random.Generator) -> Sensor:
    """A sensor of its own: the preset's noise and rounding, and errors of depth drawn anew."""
    if kind == "v1":
        base = preset("kinect-v1")
        noise = tuple(e for e in base.effects if e.name in ("axial_noise", "depth_quantization"))
        errors: tuple[Effect, ...] = (DisparityOffset(rng.normal(0, 0.1)), DepthScale(rng.normal(0, 0.005)))
    else:
        base = preset("kinect-v2-indoors")
        noise = tuple(
            e for e in base.effects if e.name in ("axial_noise", "depth_quantization", "amplitude_error",
                                                  "illumination_vignetting")
        )  # fmt: skip
        errors = (CyclicError(rng.uniform(0.003, 0.007), 0.9375, rng.uniform(0, 6)), DepthOffset(rng.normal(0, 0.01)))
    return replace(base, effects=(*noise, *errors), std={}, sources={}, left_out=())


def simulated(
    sensor: Sensor, camera: Camera, known: Sensor, z: float, drawn: tuple[int, np.random.Generator]
) -> tuple[Wall, float]:
    """A wall near this distance, reduced to means of frames, and how far it truly is [m]."""
    frames, rng = drawn
    plane = WallPlane(z + rng.uniform(-0.03, 0.03), *rng.normal(0, TILT, 2))
    view = wall_view(plane, camera, sensor)
    assert view.depth is not None
    series = PixelSeries(camera.shape)
    for _ in range(frames):
        series.add(sensor.sample(view.depth, view, None, rng))
    ir = sensor.amplitude(view) if camera.principle == Principle.TIME_OF_FLIGHT else None
    means = Means(frames, series.mean, series.std, ir)
    stated = (f"{z:.1f} m", plane.distance + rng.normal(0, LASER), LASER)
    return wall_of(means, camera, known, stated), plane.distance


def wall_view(plane: WallPlane, camera: Camera, sensor: Sensor) -> View:
    """What the sensor looks at."""
    depth = plane.depth(camera)
    normal = -np.array([plane.a, plane.b, 1.0]) / np.sqrt(plane.a**2 + plane.b**2 + 1)
    incidence = incidence_of(np.broadcast_to(normal, (*camera.shape, 3)), camera)
    white = np.full(camera.shape, WHITE)
    return View(camera, depth, incidence, reflectance=white, baseline=sensor.baseline, principle=sensor.principle)


def judged(found: DepthCalibration, sensor: Sensor, camera: Camera, least: float) -> Outcome:
    """The curve against the truth: what the sensor does on the axis to a frontal wall."""
    assert found.curve is not None
    curve = found.curve
    exact = replace(sensor, effects=tuple(e for e in sensor.effects if e.name != "depth_quantization"), left_out=())
    pixel = replace(camera, width=1, height=1, cx=0.0, cy=0.0)
    truth = np.array(
        [float(exact.predict(np.full((1, 1), z), wall_view(WallPlane(float(z), 0, 0), pixel, sensor))[0, 0] - z)
         for z in curve.distance]
    )  # fmt: skip
    error = curve.bias - truth
    near, far = ((curve.distance >= 0.7) & (curve.distance <= limit) for limit in (2.0, 3.0))
    return Outcome(
        float(np.sqrt(np.mean(error[near] ** 2))),
        least,
        float((np.abs(error) / curve.distance)[far].max()),
        float((np.abs(error) <= curve.half_width)[far].mean()),
        found.best.candidate.name,
    )


if __name__ == "__main__":
    sys.exit(main())
