"""Are perfect frames that went through a sensor told from frames that the simulator made of the same scene at once?

    python -m tools.reproduce.ideal_frames [--frames 12] [--seed 1] [--given all | channels | depth] [--json FILE]

Two-sample test for each of 20 pairs of scene and sensor. One sample is the simulator's own frames, which see sub-pixel
edges, hidden surfaces and true normals; the other its ideal frames sent through `fusion.sense`. These carry what any
renderer can tell of a moment (`--given all`): depth, normals, reflectance, a shadow pass of the projector, and
depth between the pixels, 64 values a pixel along rows and columns: the own simulator bisects edges to a 64th.
`--given channels` leaves out what is between the pixels; `--given depth` gives depth and the reflectance that an ideal
IR image tells, and nothing else. Every frame has a seed of its own, so frames are independent. A frame
becomes the mean error, the spread and the missing share of 48 tiles; the statistic is the sum over these of the squared
difference of the two samples' means over its variance; p is its place among relabelled samples (permutation test).
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Principle
from fusion.sensor.correction.estimate import reflectance_of
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.passes import FINER, ideal_of
from fusion.simulation.ideal.sense import sense
from fusion.simulation.ideal.slopes import facing_of
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import Simulation, simulate

SCENES: dict[str, dict[str, Any]] = {
    "wall": {"distance_m": 1.2, "frames": 1},
    "target": {"frames": 1},
    "step": {"frames": 1},
    "corner": {"frames": 1},
    "patches": {"frames": 1},
    "checkerboard": {"frames": 1},
    "near-card": {},
    "warm-up": {},
    "turntable": {"frames": 1},
    "room": {"frames": 1},
}
SENSORS = ("kinect-v1", "kinect-v2-indoors")
TILES = (6, 8)
RELABELLED = 999
Floats = NDArray[np.floating]


def features(depth: Floats, ideal: Floats) -> Floats:
    """(n,) mean error, spread of the error and missing share of each tile; 0 where a tile shows nothing."""
    error = (depth - ideal)[: TILES[0] * (depth.shape[0] // TILES[0]), : TILES[1] * (depth.shape[1] // TILES[1])]
    there = np.isfinite(ideal[: error.shape[0], : error.shape[1]])
    height, width = (size // count for size, count in zip(error.shape, TILES, strict=True))

    def tiles(values: Floats) -> Floats:
        shaped = values.reshape(TILES[0], height, TILES[1], width)
        return shaped.transpose(0, 2, 1, 3).reshape(TILES[0] * TILES[1], -1)

    known = tiles(np.isfinite(error).astype(float))
    values = np.where(known > 0, np.nan_to_num(tiles(error)), 0.0)
    count = np.maximum(known.sum(axis=1), 1)
    mean = values.sum(axis=1) / count
    spread = np.sqrt((known * (values - mean[:, None]) ** 2).sum(axis=1) / count)
    surface = tiles(there.astype(float)).sum(axis=1)
    return np.concatenate([mean, spread, 1 - known.sum(axis=1) / np.maximum(surface, 1)])


def p_value(one: Floats, other: Floats, rng: np.random.Generator) -> float:
    """Share of relabelled samples (n, features) and (m, features) that differ as much as these."""
    both = np.concatenate([one, other])
    scale = both.var(axis=0)
    both = both[:, scale > 0] / np.sqrt(scale[scale > 0])
    if not both.shape[1]:
        return 1.0

    def apart(order: NDArray[np.intp]) -> float:
        first, second = both[order[: len(one)]], both[order[len(one) :]]
        return float(((first.mean(axis=0) - second.mean(axis=0)) ** 2).sum())

    told = apart(np.arange(len(both)))
    return (1 + sum(apart(rng.permutation(len(both))) >= told for _ in range(RELABELLED))) / (1 + RELABELLED)


def samples(name: str, sensor: Sensor, frames: int, seed: int, given: str = "all") -> tuple[Floats, Floats]:
    """Features of the simulator's own frames, and of ideal ones that went through the sensor.

    `given`: "all" that a renderer can tell, "channels" without the depth between the pixels, or "depth" and what an
    ideal IR image tells of the reflectance.
    """
    scene = built_in(name, SCENES[name])
    simulation = simulate(scene, sensor)
    ideal = next(ideal_of(simulation, FINER if given == "all" else 1))
    if given == "depth":
        ideal = IdealFrame(ideal.depth, reflectance=_told_by_ir(simulation, ideal, seed), moment=ideal.moment)
    own, sent = [], []
    for number in range(frames):
        made = next(simulate(scene, sensor, seed + 1 + number).frames())
        own.append(features(made.depth, ideal.depth))
        made = sense(ideal, simulation.camera, sensor, seed + 10_001 + number)
        sent.append(features(made.depth, ideal.depth))
    return np.array(own), np.array(sent)


def _told_by_ir(simulation: Simulation, ideal: IdealFrame, seed: int) -> NDArray[np.float32] | None:
    """(h, w) reflectance by the IR image of a sensor without errors; None where it makes none."""
    camera = replace(simulation.camera, principle=Principle.UNKNOWN)
    frame = next(simulate(replace(simulation.scene, camera=camera), Sensor(), seed).frames())
    if frame.ir is None:
        return None
    with np.errstate(all="ignore"):
        incidence = facing_of(ideal.depth, camera, normals=False).incidence
        seen = View(camera, ideal.depth, incidence, ir=frame.ir)
        return np.clip(reflectance_of(seen), 0, 1).astype(np.float32)


def main() -> None:
    """Test all pairs and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=12, help="of each sample (default: 12)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--given", choices=("all", "channels", "depth"), default="all")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    found = {}
    for name in SCENES:
        for word in SENSORS:
            own, sent = samples(name, read_sensor(word), options.frames, options.seed, options.given)
            p = p_value(own, sent, np.random.default_rng(options.seed))
            found[f"{name}, {word}"] = p
            print(f"{name:<14}{word:<20}p = {p:.3f}")
    passed = sum(p > 0.05 for p in found.values())
    print(f"{passed} of {len(found)} with p > 0.05")
    if options.json is not None:
        options.json.write_text(json.dumps({"p": found, "passed": passed}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
