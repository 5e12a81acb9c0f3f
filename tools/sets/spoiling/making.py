"""A spoiled scan becomes a recording and the truth, laid out as the first pass of two."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.fresh.statue import statue
from tools.sets.judging.writing import Recording, trajectory
from tools.sets.planted.devices import Flight
from tools.sets.planted.shapes import BRIGHT, PLAIN, Array, Rng, joined, paint
from tools.sets.planted.stage import OBJECT, STILL, Hits, Solid, turned
from tools.sets.spoiling.cases import Spoiled
from tools.sets.spoiling.plate_light import added
from tools.sets.two_passes.cases import CAMERAS, OBJECTS, Way
from tools.sets.two_passes.making import EVERY, STD, Pass, camera_of, pass_of

WARM = {"itof": 0.008}  # [m], and where not listed [px], that the depth drifts by over the scan
DRIFT_PX = 0.4
ROCKS = np.deg2rad(1.0)  # the plate leans to and fro by as much, twice a turn
SHINY = 0.93  # cosine from which a shiny surface gives no depth


def thin(rng: Rng, height: float) -> trimesh.Trimesh:
    """A block with rods of 2 to 4 mm and a fin of 1.5 mm."""
    parts = [trimesh.creation.box([0.09, 0.07, height / 2])]
    parts[0].apply_translation([0, 0, height / 4])
    for k, radius in enumerate((0.001, 0.0015, 0.002)):
        rod = trimesh.creation.cylinder(radius, height / 2 + 0.01)
        rod.apply_translation([0.03 * (k - 1), 0.02, 0.75 * height - 0.005])
        parts.append(rod)
    fin = trimesh.creation.box([0.07, 0.0015, height / 3])
    fin.apply_translation([0, -0.02, height / 2 + height / 6 - 0.005])
    return joined([*parts, fin])


def vase(rng: Rng, height: float) -> trimesh.Trimesh:
    """A thing of revolution."""
    z = np.linspace(0, 1, 60)
    r = 0.3 * (0.7 + 0.25 * np.sin(5 * z + 0.4))
    outline = np.column_stack([np.concatenate([[0], r, [0]]), np.concatenate([[0], z, [1]])]) * height
    return trimesh.creation.revolve(outline, sections=180)


THINGS = OBJECTS | {"thin": thin, "vase": vase, "statue": statue}


def make(case: Spoiled, folder: Path, rng: Rng) -> None:
    """Write `folder/pass_1` and `folder/truth`."""
    device = CAMERAS[case.camera]
    if case.what == "flying":
        assert isinstance(device, Flight)
        device = replace(device, dropped=0.0)
    item = THINGS[case.shape](rng, case.height)
    printed = paint(rng, PLAIN if case.plain else BRIGHT, 0.06)
    one = pass_of(rng, Way(case.camera, case.degrees), (item, printed), turned(rng.uniform(0, 360)), case.frames)
    steps = 1 + case.uneven * rng.uniform(-1, 1, case.frames - 1)
    angles = np.append(0, np.cumsum(steps)) * case.degrees / steps.sum()
    recording = Recording(folder / "pass_1", camera_of(case.camera, True, 1 + STD * 0.5))
    poses = []
    for i, angle in enumerate(angles):
        T_plate, T_item = _standing(case, i / case.frames, angle)
        hits, colours = one.stage.seen(one.stage.backdrop(one.stage.T_world_camera), T_plate, T_item)
        if case.what == "hand" and 0.2 < (i / case.frames) % 0.5 < 0.32:
            hits, colours = _reached(one, hits, colours, i)
        bend = _bend(case, one, hits, i / case.frames, device.principle)
        depth = device.depth(hits, bend, rng)  # type: ignore[arg-type]
        if case.what == "shiny":
            depth = np.where((hits.part == OBJECT) & (hits.cosine > SHINY), 0.0, depth)
        recording.depth(100 + EVERY * i, depth)
        recording.rgb(100 + EVERY * i, colours)
        poses.append(np.linalg.inv(T_item @ one.T_plate_object) @ one.stage.T_world_camera)
    recording.done(**({"turntable_deg": np.abs(angles)} if case.log else {}))
    truth = folder / "truth"
    truth.mkdir(parents=True, exist_ok=True)
    item.export(truth / "object.ply")
    trajectory(truth / "poses_1.txt", 100 + EVERY * np.arange(case.frames), np.array(poses))
    (truth / "truth.json").write_text(
        json.dumps({"name": case.name, "said": case.said, "options": case.options}), encoding="utf-8"
    )


def _standing(case: Spoiled, share: float, angle: float) -> tuple[Array, Array]:
    """Poses of plate and object after a share of the scan."""
    T = turned(angle)
    if case.what == "wobble":
        T = trimesh.transformations.rotation_matrix(ROCKS * np.sin(2 * np.deg2rad(angle)), [0.6, 0.8, 0]) @ T
    moved = np.eye(4)
    if case.what == "moved" and share > 0.5:
        moved = turned(3.0)
        moved[0, 3] = 0.005
    return T, T @ moved


def _bend(case: Spoiled, one: Pass, hits: Hits, share: float, principle: str) -> Array | float:
    if case.what == "warm-up":
        return WARM.get(principle, DRIFT_PX) * (1 - np.exp(-3 * share))
    return added(one.stage, hits) if case.what == "plate light" else 0.0


def _reached(one: Pass, hits: Hits, colours: NDArray[np.uint8], i: int) -> tuple[Hits, NDArray[np.uint8]]:
    """An arm that reaches to the object from the right, and turns it."""
    top = float(one.stage.item.mesh.bounds[1, 2])
    wide = float(one.stage.item.mesh.bounds[1, 0])
    hand = trimesh.creation.capsule(0.3, 0.035)
    hand.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    hand.apply_translation([wide + 0.02 + 0.01 * (i % 3), -0.02, 0.6 * top])
    camera = one.stage.camera
    z, cosine, point = Solid(hand).hit(one.stage.T_world_camera, camera.rays.reshape(-1, 3))
    shape = hits.z.shape
    z, cosine, point = z.reshape(shape), cosine.reshape(shape), point.reshape(*shape, 3)
    first = z < hits.z
    colours = colours.copy()
    colours[first] = (np.array([224, 172, 140]) * (0.35 + 0.65 * cosine[first])[:, None]).astype(np.uint8)
    part = np.where(first, STILL, hits.part).astype(np.int8)
    there = first[..., None]
    nearer = np.where(first, z, hits.z), part, np.where(first, cosine, hits.cosine), np.where(there, point, hits.point)
    return Hits(*nearer), colours
