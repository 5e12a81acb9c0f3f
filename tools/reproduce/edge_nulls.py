"""Boards before a wall of which the model knows all: does `fusion explain` stay silent about what edges do?

    python -m tools.reproduce.edge_nulls -o OUT --seeds 1 2 4

Each case is spoiled in one way in which recordings are: poses, camera file, mesh, rounding, shaking. Names of effects
that act at depth edges are counted, established and indicated; there is nothing to name.
"""

import argparse
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from fusion.discrepancy.explain import explain
from fusion.recording.cameras.presets import find_camera
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording
from fusion.sensor.effect import Effect
from fusion.sensor.effects.optics.defocus import Defocus
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.sensor import Sensor
from fusion.simulation.scene.scene import Scene
from fusion.simulation.scenes import built_in
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation
from tools.reproduce.named_effects import NOISE, SMALL, Principle

DISTANCES_M = (0.7, 1.0, 1.5, 2.2)
WIDTH_M = 0.3
FLIGHT, LIGHT = Principle.TIME_OF_FLIGHT, Principle.STRUCTURED_LIGHT
MANY = 10.0  # times worse than stated
OFF_PX, OFF_M, STEP_M = 1.0, 0.001, 0.02


@dataclass(frozen=True)
class Null:
    """A way to record in which no effect is missing."""

    name: str
    effects: tuple[Effect, ...] = ()  # that the camera has and the model knows
    scene: str = "step"
    hidden: tuple[Effect, ...] = ()  # that are none of edges, and the model lacks
    spoiled: Callable[[Scene], Scene] | None = None  # what is recorded, beside what is stated
    after: Callable[[Path], None] | None = None  # what becomes of the files


def _worse_poses(scene: Scene) -> Scene:
    assert scene.poses is not None
    return replace(scene, poses=replace(scene.poses, sigma_m=MANY * SURVEY_M, sigma_rad=MANY * SURVEY_RAD))


def _wider(scene: Scene) -> Scene:
    near = scene.parts[0]
    vertices = near.mesh.vertices.copy()
    vertices[:, 1] += np.where(vertices[:, 1] > vertices[:, 1].mean(), OFF_M, -OFF_M)
    return replace(scene, parts=(replace(near, mesh=replace(near.mesh, vertices=vertices)), *scene.parts[1:]))


def _other_centre(folder: Path) -> None:
    file = folder / "camera.json"
    stated = json.loads(file.read_text(encoding="utf-8"))
    stated["cx"] += OFF_PX
    file.write_text(json.dumps(stated), encoding="utf-8")


def _coarse(folder: Path) -> None:
    recording = open_recording(folder)
    frames = list(recording)
    rounded = [replace(f, depth=(np.rint(f.depth / STEP_M) * STEP_M).astype(np.float32)) for f in frames]
    kept = [folder / name for name in ("scene.json", "scene.ply", "groundtruth.txt")]
    texts = [(file, file.read_bytes()) for file in kept if file.exists()]
    camera = recording.camera
    shutil.rmtree(folder)
    write_recording(folder, camera, iter(rounded), None)
    for file, content in texts:
        file.write_bytes(content)


NULLS = (
    Null("as stated"),
    Null("no edges", scene="wall"),
    Null("the model has them: mixed pixels", (MixedPixels(fill=1.0),)),
    Null("the model has them: defocus", (Defocus(width=0.7),)),
    Null("the model has them: lateral noise", (LateralNoise(sigma_px=0.6),)),
    Null("the model has them: fattening", (EdgeFattening(window_px=5.0),)),
    Null("poses 10 times worse", spoiled=_worse_poses),
    Null("poses 10 times worse, mixed pixels known", (MixedPixels(fill=1.0),), spoiled=_worse_poses),
    Null("cx off by 1 px", after=_other_centre),
    Null("cx off by 1 px, defocus known", (Defocus(width=0.7),), after=_other_centre),
    Null("board 1 mm wider to each side", spoiled=_wider),
    Null("board 1 mm wider to each side, fattening known", (EdgeFattening(window_px=5.0),), spoiled=_wider),
    Null("frames shaken by 1 mm and 1 mrad", hidden=(PoseJitter(sigma_m=0.001, sigma_rad=0.001),)),
    Null("frames shaken by 5 mm and 3 mrad", hidden=(PoseJitter(sigma_m=0.005, sigma_rad=0.003),)),
    Null("frames shaken by 1 mm to the sides only", hidden=(PoseJitter(sigma_m=0.001),)),
    Null("depth in steps of 20 mm", after=_coarse),
)


def main() -> int:
    """Make, explain, count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--only", default="", help="cases with this in their name")
    options = parser.parse_args()
    told, asked = [0, 0], 0
    for null, principle, width in _asked(options.only):
        for seed in options.seeds:
            established, indicated = _names(null, principle, width, seed, options.output)
            asked += 1
            told[0] += bool(established)
            told[1] += bool(indicated)
            sides = "two edges" if width else "one edge"
            said = [f"established: {', '.join(established)}"] * bool(established)
            said += [f"indicated: {', '.join(indicated)}"] * bool(indicated)
            print(f"{null.name:<50} {principle:<17} {sides:<10} {seed:3d}  {'; '.join(said) or '-'}", flush=True)
    print(f"{asked} nulls: {told[0]} with a claim, {told[1]} with an indication")
    return 0


def _asked(part: str) -> Iterator[tuple[Null, Principle, float]]:
    for null in NULLS:
        for principle in (FLIGHT, LIGHT):
            mixed = any(isinstance(effect, MixedPixels) for effect in null.effects)
            other = [effect for effect in null.effects if effect.principles and principle not in effect.principles]
            if part in null.name and not other and not (mixed and principle == LIGHT):
                for width in (0.0, WIDTH_M) if null.scene == "step" else (0.0,):
                    yield null, principle, width


def _names(null: Null, principle: Principle, width: float, seed: int, output: Path) -> tuple[list[str], list[str]]:
    """Effects at edges that are established and indicated."""
    name, size = SMALL[principle]
    camera = find_camera(name).resized(*size)
    sensor = Sensor(name="model", principle=principle, effects=(NOISE[principle],))
    for effect in null.effects:
        sensor = sensor.having(effect)
    made_with = sensor
    for effect in null.hidden:
        made_with = made_with.having(effect)
    folder = output / "case"
    shutil.rmtree(folder, ignore_errors=True)
    for number, distance in enumerate(DISTANCES_M):
        settings = {"distance_m": str(distance), "frames": "6"}
        if null.scene == "step":
            settings["width_m"] = str(width)
        stated = replace(built_in(null.scene, settings), camera=camera)
        one = folder / f"rec_{number}"
        seen = stated if null.spoiled is None else null.spoiled(stated)
        write_simulation(one, simulate(seen, made_with, 1000 * seed + number))
        if null.spoiled is not None:
            write_simulation(output / "stated", simulate(stated, sensor))
            for file in ("scene.json", "scene.ply"):
                shutil.copy(output / "stated" / file, one / file)
        if null.after is not None:
            null.after(one)
    found = explain([open_recording(path) for path in sorted(folder.iterdir())], sensor)
    shutil.rmtree(folder)
    told: tuple[list[str], list[str]] = ([], [])
    for step in found.channels.of("edges"):
        if step.effect is not None:
            told[not step.established].append(" | ".join((step.effect.name, *step.alike)))
    return told


if __name__ == "__main__":
    sys.exit(main())
