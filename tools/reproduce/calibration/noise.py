"""Targets simulated for Kinect v1 and v2, calibrated as `fusion calibrate noise` does, against the noise put in.

    python -m tools.reproduce.calibration.noise [--seeds 10] [--frames 50] [--only v1 v2] [--uncorrected] [--json FILE]

The grid of Fankhauser: 0.7 to 3.1 m in steps of 0.3 m, 0 to 75 deg in steps of 15 deg, each a little off at random.
The images are cut out around the target, to save time. The depth errors of the unit are taken as known, as after
`fusion calibrate depth`; with --uncorrected they are not, and turn steep targets by up to a degree.
"""

import argparse
import json
import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from fusion.calibration.noise.calibration import NoiseCalibration, calibrate_poses
from fusion.calibration.noise.laws.axial import AxialLaw
from fusion.calibration.noise.poses import Pose, pose_of
from fusion.calibration.noise.target_noise import measure_target
from fusion.errors import FusionError
from fusion.geometry.camera import Camera, Principle
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.simulation.rendering.render import Channels, render

CAMERAS = {
    "v1": Camera(
        640, 480, 585.0, 585.0, 319.5, 239.5, principle=Principle.STRUCTURED_LIGHT, sensor="Kinect for Xbox 360"
    ),
    "v2": Camera(512, 424, 365.0, 365.0, 255.5, 211.5, principle=Principle.TIME_OF_FLIGHT, sensor="Kinect v2"),
}
PRESETS = {"v1": "kinect-v1", "v2": "kinect-v2-indoors"}
DISTANCES, TILTS = np.arange(0.7, 3.11, 0.3), np.arange(0, 76, 15)
WHITE = 0.8
NOISE = ("axial_noise", "lateral_noise")
# what the issue asks: numbers within 2 standard deviations of the truth, 90 % intervals that cover 85 to 95 %
WITHIN, COVERED = 2.0, (0.85, 0.95)


@dataclass(frozen=True)
class Outcome:
    """One seed: each number's error in standard deviations, and the share of the law that its 90 % interval covers.

    Attributes:
        pulls: number to its error over its standard deviation.
        inside: whether the 90 % interval of each number holds the truth.
        covered: share of distances and tilts at which the law's interval holds the true noise.
        error: largest error of the law as a share, over the grid.
        form: which law was chosen.
    """

    pulls: dict[str, float]
    inside: list[bool]
    covered: float
    error: float
    form: str


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--frames", type=int, default=50)
    parser.add_argument("--only", nargs="*", default=["v1", "v2"], choices=("v1", "v2"))
    parser.add_argument("--uncorrected", action="store_true", help="the unit's depth errors are not known")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    results, good = {}, True
    for kind in options.only:
        found = [outcome(kind, seed, options.frames, not options.uncorrected) for seed in range(options.seeds)]
        for seed, one in enumerate(found):
            text = ", ".join(f"{name} {pull:+.2f}" for name, pull in one.pulls.items())
            print(f"  {kind} seed {seed}: off by [std] {text}; law covered {one.covered:.2f}, "
                  f"off by up to {100 * one.error:.1f} %  {one.form}")  # fmt: skip
        pulls = np.array([pull for one in found for pull in one.pulls.values()])
        inside = float(np.mean([x for one in found for x in one.inside]))
        covered = float(np.mean([one.covered for one in found]))
        within = float(np.mean(np.abs(pulls) <= WITHIN))
        fine = within >= 0.9 and COVERED[0] - 0.05 <= covered <= COVERED[1] + 0.05
        good &= fine
        print(
            f"{kind}: {100 * within:.0f} % of {len(pulls)} numbers within 2 standard deviations (rms pull "
            f"{np.sqrt(np.mean(pulls**2)):.2f}); 90 % intervals hold {100 * inside:.0f} % of the numbers and "
            f"{100 * covered:.0f} % of the law (asked 85 to 95){'' if fine else '  !'}"
        )
        results[kind] = {"within_2_std": within, "numbers_covered": inside, "law_covered": covered,
                         "pulls": [one.pulls for one in found], "forms": [one.form for one in found],
                         "law_error": [one.error for one in found]}  # fmt: skip
    if options.json:
        options.json.write_text(json.dumps(results, indent=1) + "\n")
    return 0 if good else 1


def outcome(kind: str, seed: int, frames: int, corrected: bool = True) -> Outcome:
    """Simulate, calibrate, compare."""
    rng = np.random.default_rng([seed, ord(kind[1])])
    sensor, camera = preset(PRESETS[kind]), CAMERAS[kind]
    known = replace(sensor, effects=tuple(e for e in sensor.effects if e.name not in NOISE), std={}, left_out=())
    known = known if corrected else replace(known, effects=(), sources={})
    poses = []
    for z in DISTANCES:
        for tilt in TILTS:
            with suppress(FusionError):  # at 0.7 m a white target is too bright for a Kinect v2
                poses.append(simulated(sensor, camera, known, (float(z), float(tilt)), (frames, rng)))
    return judged(calibrate_poses(poses, camera, known), sensor)


def simulated(
    sensor: Sensor, camera: Camera, known: Sensor, place: tuple[float, float], drawn: tuple[int, np.random.Generator]
) -> Pose:
    """A target near this distance [m] and tilt [deg], measured over some frames."""
    lit = sensor.baseline if sensor.principle == Principle.STRUCTURED_LIGHT else None
    view = seen_at(camera, place, lit, int(drawn[1].integers(2)))
    return measured(sensor, view, known, drawn, f"{place[0]:.1f} m, {place[1]:.0f} deg")


def measured(sensor: Sensor, view: View, known: Sensor, drawn: tuple[int, np.random.Generator], name: str) -> Pose:
    """What the calibration makes of some frames of a view."""
    (frames, rng), part = drawn, view.camera
    assert view.depth is not None
    depths = [np.round(sensor.sample(view.depth, view, None, rng) * part.depth_scale) / part.depth_scale
              for _ in range(frames)]  # fmt: skip
    ir = sensor.amplitude(view) if sensor.principle == Principle.TIME_OF_FLIGHT else None
    clean = replace(known, left_out=())
    correct = (lambda mean: clean.correct(mean, View(part, mean, ir=ir))) if clean.effects else None
    seen = measure_target(depths, part, correct=correct)
    light = float(ir[seen.middle].mean()) if ir is not None else float("nan")
    return pose_of(seen, name, part, known, (light, float("nan")))


@cache
def seen_at(camera: Camera, place: tuple[float, float], lit: float | None, which: int) -> View:
    """What the camera sees of a target near this distance [m] and tilt [deg]: one of a few placements."""
    rng = np.random.default_rng([round(1e3 * place[0]), round(place[1]), which])
    mesh = target_and_wall(place[0] * (1 + rng.uniform(-0.02, 0.02)), abs(place[1] + rng.uniform(-2, 2)))
    return render(mesh, cut_out(camera, mesh), np.eye(4), Channels(edges=True, lit=lit))


def target_and_wall(z: float, tilt_deg: float) -> Mesh:
    """The paper's target, larger ones farther away, and a wall behind; a roll of 3 deg, as nobody is exact."""
    size = (0.21, 0.297) if z < 0.9 else (0.297, 0.42) if z < 2.0 else (0.42, 0.594)
    # the long side is level, so that a steep target still has an inside
    half_w, half_h = 0.5 * size[1], 0.5 * size[0]
    t, roll = np.deg2rad(tilt_deg), np.deg2rad(3.0)
    across = np.array([np.cos(roll) * np.cos(t), np.sin(roll), np.cos(roll) * np.sin(t)])
    up = np.array([-np.sin(roll) * np.cos(t), np.cos(roll), -np.sin(roll) * np.sin(t)])
    corners = np.array([(a * half_w) * across + (b * half_h) * up for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    far = z + 1.0
    wall = np.array([[-9, -9, far], [9, -9, far], [9, 9, far], [-9, 9, far]], float)
    grey = np.full((8, 3), round(255 * WHITE), np.uint8)
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    return Mesh(np.concatenate([corners + np.array([0, 0, z]), wall]), faces, colors=grey)


def cut_out(camera: Camera, mesh: Mesh) -> Camera:
    """The camera with the part of its image around the target, and the shadow beside it."""
    uv = camera.project(mesh.vertices[:4])
    low = np.maximum(np.floor(uv.min(axis=0)) - np.array([40, 20]), 0).astype(int)
    high = np.minimum(np.ceil(uv.max(axis=0)) + np.array([41, 21]), [camera.width, camera.height]).astype(int)
    width, height = (int(n) for n in high - low)
    return replace(camera, width=width, height=height, cx=camera.cx - low[0], cy=camera.cy - low[1])


def judged(found: NoiseCalibration, sensor: Sensor) -> Outcome:
    """The laws against those put in."""
    true = sensor.effect("axial_noise")
    half = found.axial.best.half_width()
    pulls, inside = {}, []
    for name, value, std in zip(found.axial.form.names, found.axial.best.numbers, found.axial.best.std, strict=True):
        pulls[name] = float((value - getattr(true, name)) / std)
        inside.append(abs(pulls[name]) <= half)
    side = sensor.effect("lateral_noise")
    if found.lateral is not None and isinstance(side, LateralNoise):
        fit = found.lateral.held
        for name, value, std in zip(fit.form.names, fit.numbers, fit.std, strict=True):
            pulls[f"lateral {name}"] = float((value - getattr(side, name)) / std)
            inside.append(abs(pulls[f"lateral {name}"]) <= fit.half_width())
    z, tilt = np.meshgrid(np.linspace(0.7, 3.1, 13), np.deg2rad(np.linspace(0, 75, 11)))
    value, width = found.axial.at(z, tilt)
    truth = true_noise(found.axial, sensor, z, tilt)
    return Outcome(
        pulls,
        inside,
        float((np.abs(value - truth) <= width).mean()),
        float(np.abs(value / truth - 1).max()),
        found.axial.form.title,
    )


def true_noise(law: AxialLaw, sensor: Sensor, z: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """The axial noise put in [m]."""
    camera = Camera(z.shape[1], z.shape[0], 1e6, 1e6, 0.0, 0.0, principle=sensor.principle)
    effect = sensor.effect("axial_noise")
    assert effect is not None
    return np.asarray(effect.noise(z, View(camera, z, tilt, baseline=sensor.baseline)))


if __name__ == "__main__":
    sys.exit(main())
