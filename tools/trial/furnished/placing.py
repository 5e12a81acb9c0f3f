"""What differs between the scene that stands there and the one that the mesh tells of."""

from dataclasses import dataclass, field, replace

import numpy as np

from tools.trial.furnished.physics.bench import Bench, CameraRun
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.rooms.parts import ScenePart, grid
from tools.trial.furnished.rooms.things import things

Rng = np.random.Generator


@dataclass(frozen=True)
class PlacedScene:
    """Attributes:
    stated, true: parts of the scene.
    changed: index of the part that is not as stated, None where all are.
    also: names that are right besides.
    notes: what differs, in words.
    """

    stated: list[ScenePart]
    true: list[ScenePart]
    changed: int | None = None
    also: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def moved_thing(rng: Rng, parts: list[ScenePart]) -> PlacedScene:
    """One thing stands 6 to 20 mm from where the mesh has it."""
    movable = things(parts)
    if not movable:
        raise RuntimeError("nothing to move")
    i = int(rng.choice(movable))
    shift = rng.normal(0, 1, 3)
    shift *= rng.uniform(0.006, 0.02) / np.linalg.norm(shift)
    mesh = parts[i].mesh.copy()
    mesh.apply_translation(shift)
    true = [replace(one, mesh=mesh) if k == i else one for k, one in enumerate(parts)]
    note = f"{parts[i].name} stands {np.linalg.norm(shift) * 1e3:.0f} mm from where the mesh has it"
    return PlacedScene(parts, true, i, ["reference_shape_error"], [note])


def bowed_board(rng: Rng, parts: list[ScenePart], living: bool) -> PlacedScene:
    """A board more, flat in the mesh, that is bowed by 1 to 3 mm."""
    bow = rng.uniform(0.001, 0.003)
    corner = np.array([rng.uniform(1.2, 1.7), rng.uniform(-0.6, 0.2), rng.uniform(0.3, 0.7)])
    along, up = np.array([0.3, 0.9, 0]), np.array([-0.1, 0.05, 0.9])
    if living:  # whose walls begin at 0
        corner[1] += 1.5

    def height(a: Array, b: Array) -> Array:
        return bow * (1 - 4 * (a - 0.5) ** 2)

    flat = grid(corner, along, up, (12, 12), 0.7, "bowed board")
    bowed = grid(corner, along, up, (12, 12), 0.7, "bowed board", height)
    note = f"a board is bowed by {bow * 1e3:.1f} mm, the mesh has it flat"
    return PlacedScene([*parts, flat], [*parts, bowed], len(parts), ["reference_shape_error"], [note])


def must_be_seen(bench: Bench, recordings: list[CameraRun], part: int) -> None:
    """Complains where a part fills less than 2 % of the first images."""
    rays = bench.directions(bench.camera)
    shares = [np.mean(bench.world.cast(one.stated(one.times[0]), rays).part == part) for one in recordings]
    if np.mean(shares) < 0.02:
        raise RuntimeError("the moved thing is not seen")
