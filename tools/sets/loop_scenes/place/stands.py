"""A thing on a table, in a room: what is scanned by walking round it."""

from dataclasses import dataclass

import numpy as np
import trimesh

from tools.sets.loop_scenes.place.pieces import Item, ball, box, joined, rod
from tools.sets.loop_scenes.place.prints import POSTER, WOOD, Array, Rng, printed
from tools.sets.loop_scenes.place.rooms import Room, room

TOP = 0.72  # [m]


@dataclass(frozen=True)
class Stand:
    """Attributes:
    items: the room, the table, what lies on it, the thing.
    aim: (3,) [m] the middle of the thing.
    reach: [m] from there to its farthest point.
    """

    items: list[Item]
    aim: Array
    reach: float


def stand(rng: Rng) -> Stand:
    """A table in the middle of a room that can be walked round."""
    around: Room = room(rng, (4.4, 4.0), None)
    w, d = rng.uniform([0.9, 0.6], [1.2, 0.75])
    legs = [
        rod(0.03, [x, y, 0], [x, y, TOP - 0.03])
        for x in (0.05 - w / 2, w / 2 - 0.05)
        for y in (0.05 - d / 2, d / 2 - 0.05)
    ]
    top = joined([box([-w / 2, w / 2], [-d / 2, d / 2], [TOP - 0.03, TOP]), *legs])
    item = thing(rng)
    item.apply_translation([0, 0, TOP])
    items = [*around.items, Item(top, printed(rng, WOOD, 0.08)), Item(item, printed(rng, POSTER, 0.045))]
    for way in rng.uniform(0, 2 * np.pi) + np.arange(3) * 2.1:
        x, y = (0.24 + rng.uniform(0, 0.06)) * np.array([np.cos(way), np.sin(way)])
        items.append(Item(small(rng, x, y), printed(rng, POSTER, 0.03)))
    aim = np.asarray(item.bounds.mean(axis=0), float)
    reach = float(np.linalg.norm(np.asarray(item.vertices) - aim, axis=1).max())
    return Stand(items, aim, reach)


def thing(rng: Rng) -> trimesh.Trimesh:
    """About 25 cm high: a body with a head, arms, and a box beside it; no symmetry."""
    high = rng.uniform(0.22, 0.28)
    parts = [ball([0.3 * high, 0.24 * high, 0.34 * high], [0, 0, 0.33 * high])]
    parts += [ball([0.2 * high, 0.18 * high, 0.2 * high], [0.05 * high, 0, 0.78 * high])]
    parts += [rod(0.05 * high, [0.2 * high, 0.1 * high, 0.5 * high], [0.55 * high, 0.3 * high, 0.75 * high])]
    parts += [rod(0.05 * high, [-0.2 * high, 0.1 * high, 0.5 * high], [-0.5 * high, 0.25 * high, 0.25 * high])]
    parts += [ball([0.05 * high] * 3, [(0.05 + 0.12 * s) * high, -0.07 * high, 0.92 * high]) for s in (-1, 1)]
    beside = trimesh.creation.box(rng.uniform([0.3, 0.2, 0.3], [0.5, 0.4, 0.6]) * high)
    beside.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0.2, 1.3), [0, 0, 1]))
    beside.apply_translation([-0.15 * high, -0.42 * high, -beside.bounds[0, 2]])
    out = joined([*parts, beside])
    out.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0, 6), [0, 0, 1]))
    return out


def small(rng: Rng, x: float, y: float) -> trimesh.Trimesh:
    """A cup or a little box that lies on the table."""
    if rng.random() < 0.5:
        return rod(rng.uniform(0.03, 0.04), [x, y, TOP], [x, y, TOP + rng.uniform(0.06, 0.1)])
    one = trimesh.creation.box(rng.uniform(0.04, 0.1, 3))
    one.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0, 1.5), [0, 0, 1]))
    one.apply_translation([x, y, TOP - one.bounds[0, 2]])
    return one
