"""Two rooms: furniture along the walls, drawn anew for each seed."""

from dataclasses import dataclass

import numpy as np
import trimesh

from tools.sets.loop_scenes.place.pieces import PIECES, Item, box
from tools.sets.loop_scenes.place.prints import PAPER, POSTER, TILES, WHITE, Array, Rng, printed

HEIGHT = 2.5  # [m] of a room
MARGIN = 0.15  # [m] between a corner and the first piece


@dataclass(frozen=True)
class Room:
    """Attributes:
    items: walls, floor, ceiling and furniture.
    size: [m] along x and y; the origin is the middle of the floor.
    bare: directions [rad] as seen from the middle between which nothing stands (first, last), or None.
    """

    items: list[Item]
    size: tuple[float, float]
    bare: tuple[float, float] | None


def room(rng: Rng, size: tuple[float, float], bare: int | None) -> Room:
    """A room of this size [m]; against wall number `bare` (0 to 3) stands nothing."""
    items = shell(rng, size)
    kinds = ["shelf", "cupboard", "table", "sofa", "cupboard", "crates", "plant", "chair", "lamp", "chair"]
    kinds += ["shelf", "crates", "chair", "plant"]
    left = [str(kind) for kind in rng.permutation(kinds)]
    for wall in range(4):
        T, length = placed(wall, size)
        items += posters(rng, T, length, 5 if wall == bare else 3, 0.5 if wall == bare else 1.0)
        if wall == bare:
            continue
        x = -length / 2 + MARGIN + (0.5 if wall % 2 else 0.0)  # a corner is taken by one of its walls only
        while left:
            fits = [kind for kind in left if x + PIECES[kind][1] < length / 2 - MARGIN]
            if not fits:
                break
            build, width = PIECES[fits[0]]
            left.remove(fits[0])
            at = trimesh.transformations.translation_matrix([x + width / 2, 0.02, 0])
            items += [item.moved(T @ at) for item in build(rng)]
            x += width + rng.uniform(0.02, 0.25)
    return Room(items, size, None if bare is None else directions(bare, size))


def shell(rng: Rng, size: tuple[float, float]) -> list[Item]:
    """Floor, ceiling, four walls, and a pillar in one corner."""
    x, y = size[0] / 2, size[1] / 2
    thick = 0.1
    walls = [
        box([x, x + thick], [-y - thick, y + thick], [0, HEIGHT]), box([-x, x], [y, y + thick], [0, HEIGHT]),
        box([-x - thick, -x], [-y - thick, y + thick], [0, HEIGHT]), box([-x, x], [-y - thick, -y], [0, HEIGHT]),
    ]  # fmt: skip
    floor, ceiling = box([-x, x], [-y, y], [-thick, 0]), box([-x, x], [-y, y], [HEIGHT, HEIGHT + thick])
    wide = rng.uniform(0.2, 0.35)
    pillar = box([x - wide, x], [y - wide, y], [0, HEIGHT])
    items = [Item(wall, printed(rng, PAPER, 0.12, 0.1), shell=True) for wall in [*walls, pillar]]
    ends = [Item(floor, printed(rng, TILES, 0.2, 0.2), shell=True), Item(ceiling, printed(rng, WHITE, 0.8), shell=True)]
    return [*items, *ends]


def posters(rng: Rng, T: Array, length: float, count: int, lowest: float) -> list[Item]:
    """Paper of a millimetre on a wall, `lowest` [m] and more over the floor: seen in colour, not in depth."""
    out = []
    for k in range(count):
        w, h = rng.uniform([0.3, 0.3], [0.6, 0.7])
        x = -length / 2 + (k + 0.5) * length / count + rng.uniform(-0.1, 0.1)
        z = lowest + rng.uniform(0.0, 0.6)
        sheet = box([x - w / 2, x + w / 2], [0, 0.001], [z, z + h])
        out.append(Item(sheet, printed(rng, POSTER, rng.uniform(0.06, 0.14), 0.3), shell=True).moved(T))
    return out


def placed(wall: int, size: tuple[float, float]) -> tuple[Array, float]:
    """Pose of a wall's frame (x along it, y into the room) and its length [m]; wall 0 lies at +x, 1 at +y, ..."""
    turn = np.pi / 2 * (wall + 1)
    out = np.array(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]), float)
    way = np.pi / 2 * wall
    out[:3, 3] = [size[0] / 2 * np.cos(way), size[1] / 2 * np.sin(way), 0]
    return out, size[1] if wall % 2 == 0 else size[0]


def directions(wall: int, size: tuple[float, float]) -> tuple[float, float]:
    """[rad] from the middle of the room to the two ends of a wall."""
    T, length = placed(wall, size)
    ends = [T[:2, :2] @ [s * length / 2, 0] + T[:2, 3] for s in (-1, 1)]
    first, last = (float(np.arctan2(e[1], e[0])) for e in ends)
    return first, last if last > first else last + 2 * np.pi
