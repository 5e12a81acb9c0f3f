"""A scene and a seed become a recording, and the truth beside it."""

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tools.sets.judging.writing import Recording, trajectory
from tools.sets.loop_scenes.kinect import Kinect
from tools.sets.loop_scenes.place.prints import Rng
from tools.sets.loop_scenes.place.rooms import room
from tools.sets.loop_scenes.place.scenery import Lens, Scenery
from tools.sets.loop_scenes.place.stands import TOP, stand
from tools.sets.loop_scenes.walks import Walk, round_a_room, round_a_table

STREAM = 3001  # random numbers of these scenes alone
FULL = Lens(640, 480, 575.0)
SMALL = Lens(320, 240, 287.5)
FLAT = 0.97  # share of a picture that is walls, floor and ceiling: there is little to hold on to (guess)
OPEN = 0.45  # share of the walk after which the open scene ends: nothing is seen twice


@dataclass(frozen=True)
class Set:
    """What is recorded: scenery, walk, and what the truth says beside.

    Attributes:
        returns: the end of the walk sees what its start saw.
        middle: (3,) [m] of what is scanned, or None: the whole room.
        reach: [m] of it.
    """

    scenery: Scenery
    walk: Walk
    returns: bool
    middle: tuple[float, ...] | None = None
    reach: float | None = None


def plain(rng: Rng) -> Set:
    """A room one of whose walls has nothing before it; the camera looks outwards."""
    size = (float(rng.uniform(4.0, 4.6)), float(rng.uniform(3.6, 4.0)))
    wall = int(rng.integers(4))
    made = room(rng, size, wall)
    assert made.bare is not None
    start = made.bare[1] + np.pi + rng.uniform(-0.6, 0.6)
    return Set(Scenery(made.items), round_a_room(rng, size, start, False), True)


def lost(rng: Rng) -> Set:
    """A room; the camera looks across it, is jerked back half way and for some frames sees nothing."""
    size = (float(rng.uniform(4.2, 4.8)), float(rng.uniform(3.8, 4.2)))
    made = room(rng, size, None)
    return Set(Scenery(made.items), round_a_room(rng, size, rng.uniform(0, 6.28), True, jerked=True), True)


def carried(rng: Rng) -> Set:
    """A room; the camera is covered, and uncovered at another place of the room that it has seen before."""
    size = (float(rng.uniform(4.2, 4.8)), float(rng.uniform(3.8, 4.2)))
    made = room(rng, size, None)
    return Set(Scenery(made.items), round_a_room(rng, size, rng.uniform(0, 6.28), True, carried=True), True)


def table(rng: Rng) -> Set:
    """A thing on a table, walked round."""
    made = stand(rng)
    aim = made.aim * [1, 1, 0] + [0, 0, 0.5 * (made.aim[2] + TOP)]
    middle = tuple(float(x) for x in made.aim)
    return Set(Scenery(made.items), round_a_table(rng, aim), True, middle, made.reach)


def open_walk(rng: Rng) -> Set:
    """The first part of a walk through a room: it does not come back."""
    size = (float(rng.uniform(4.0, 4.6)), float(rng.uniform(3.6, 4.0)))
    made = room(rng, size, None)
    walk = round_a_room(rng, size, rng.uniform(0, 6.28), False)
    return Set(Scenery(made.items), walk.part(0, int(OPEN * len(walk.times))), False)


SCENES: dict[str, Callable[[Rng], Set]] = {
    "plain": plain, "lost": lost, "carried": carried, "table": table, "open": open_walk,
}  # fmt: skip
OWN = ("lost", "open", "plain", "table", "carried")  # each scene's place in the stream: new ones come last


def make(name: str, seed: int, folder: Path, lens: Lens = FULL, every: int = 1) -> None:
    """`folder/recording` and `folder/truth`; an older one is made anew. `every`: only each so-manieth frame."""
    rng = np.random.default_rng([STREAM, seed, OWN.index(name)])
    scene, camera = SCENES[name](rng), Kinect(lens)
    walk = scene.walk
    building = folder.with_name(f".{folder.name}.{os.getpid()}")
    shutil.rmtree(building, ignore_errors=True)
    truth = building / "truth"
    truth.mkdir(parents=True)
    recording = Recording(building / "recording", dict(camera.camera))
    kept, flat = range(0, len(walk.times), every), []
    for i in kept:
        view, swept = scene.scenery.seen(lens, walk.poses[i]), walk.swept[i]
        flat.append(float(view.shell.mean()) > FLAT)
        depth = camera.depth(view, swept, rng)
        recording.depth(walk.times[i], np.zeros_like(depth) if walk.blank[i] else depth)
        recording.rgb(walk.times[i], camera.nothing(rng) if walk.blank[i] else camera.picture(view, swept, rng))
    recording.done()
    trajectory(truth / "poses.txt", walk.times[kept], walk.poses[kept])
    scene.scenery.mesh.export(truth / "mesh.ply")
    told = {
        "scene": name, "seed": seed, "frames": len(kept), "returns": scene.returns,
        "blank": [k for k, i in enumerate(kept) if walk.blank[i]],
        "after_gaps": [k for k, i in enumerate(kept) if i in walk.gaps],
        "plain": [k for k, yes in enumerate(flat) if yes],
        "middle": scene.middle, "reach": scene.reach,
        "path_m": float(np.linalg.norm(np.diff(walk.poses[:, :3, 3], axis=0), axis=1).sum()),
        "turned_deg": turned(walk),
    }  # fmt: skip
    (truth / "truth.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    building.rename(folder)


def turned(walk: Walk) -> float:
    """[deg] from frame to frame, summed."""
    turns = Rotation.from_matrix(walk.poses[:, :3, :3])
    return float(np.rad2deg((turns[:-1].inv() * turns[1:]).magnitude().sum()))
