"""Furniture. Each piece stands at z = 0 with its back at y = 0 and its front towards +y, about x = 0."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh

from tools.sets.loop_scenes.place.prints import CLOTH, GREEN, POSTER, SCREEN, WHITE, WOOD, Array, Print, Rng, printed


@dataclass(frozen=True)
class Item:
    """A mesh with its print.

    Attributes:
        dark: shiny and black, it gives back nearly no light of the projector.
        shell: a wall, the floor, the ceiling, or paper on them.
    """

    mesh: trimesh.Trimesh
    print: Print
    dark: bool = False
    shell: bool = False

    def moved(self, T: Array) -> "Item":
        """At another place; its print goes with it only in kind, for a print is a function of the place."""
        mesh = self.mesh.copy()
        mesh.apply_transform(T)
        return Item(mesh, self.print, self.dark, self.shell)


def box(x: Sequence[float], y: Sequence[float], z: Sequence[float]) -> trimesh.Trimesh:
    """From low to high along each axis [m]."""
    return trimesh.creation.box(bounds=np.array([x, y, z], float).T)


def rod(radius: float, start: Sequence[float], end: Sequence[float]) -> trimesh.Trimesh:
    return trimesh.creation.cylinder(radius, segment=[start, end], sections=20)


def ball(radii: Sequence[float], centre: Sequence[float]) -> trimesh.Trimesh:
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.apply_scale(radii)
    mesh.apply_translation(centre)
    return mesh


def joined(parts: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    whole: Any = trimesh.util.concatenate(list(parts))
    return trimesh.Trimesh(whole.vertices, whole.faces, process=False)


def table(rng: Rng) -> list[Item]:
    """With a monitor, books and a mug upon it."""
    w, d, h = rng.uniform([1.1, 0.5, 0.7], [1.4, 0.6, 0.76])
    wood = joined(
        [box([-w / 2, w / 2], [0, d], [h - 0.03, h])]
        + [rod(0.025, [x, y, 0], [x, y, h - 0.03]) for x in (-w / 2 + 0.05, w / 2 - 0.05) for y in (0.05, d - 0.05)]
    )
    at = rng.uniform(-0.2, 0.2)
    screen = box([at - 0.26, at + 0.26], [0.15, 0.18], [h + 0.1, h + 0.42])
    foot = joined(
        [box([at - 0.1, at + 0.1], [0.1, 0.28], [h, h + 0.015]), rod(0.02, [at, 0.14, h], [at, 0.14, h + 0.2])]
    )
    things, x = [], -w / 2 + 0.08
    while x < at - 0.32:
        high, wide = rng.uniform(0.12, 0.26), rng.uniform(0.02, 0.05)
        things.append(box([x, x + wide], [0.1, 0.1 + rng.uniform(0.12, 0.2)], [h, h + high]))
        x += wide + rng.uniform(0.0, 0.03)
    mug = at + 0.36
    things.append(rod(0.04, [mug, 0.3, h], [mug, 0.3, h + 0.1]))
    return [
        Item(wood, printed(rng, WOOD, 0.2)),
        Item(screen, printed(rng, SCREEN, 0.3), dark=True),
        Item(foot, printed(rng, WHITE, 0.2)),
        Item(joined(things), printed(rng, POSTER, 0.07)),
    ]


def shelf(rng: Rng) -> list[Item]:
    """Boards with rows of books."""
    w, d, h = rng.uniform([0.8, 0.28, 1.6], [1.1, 0.34, 2.0])
    levels = np.linspace(0.02, h - 0.02, int(rng.integers(5, 7)))
    wood = [box([s * w / 2 - 0.01, s * w / 2 + 0.01], [0, d], [0, h]) for s in (-1, 1)]
    wood += [box([-w / 2, w / 2], [0, d], [z - 0.01, z + 0.01]) for z in levels]
    wood += [box([-w / 2, w / 2], [0, 0.01], [0, h])]
    books = []
    for z in levels[:-1]:
        x = -w / 2 + 0.03
        end = w / 2 - rng.uniform(0.03, 0.4)
        while x < end:
            wide, high, deep = rng.uniform([0.02, 0.15, 0.14], [0.06, 0.26, 0.24])
            books.append(box([x, x + wide], [0.02, 0.02 + deep], [z + 0.01, z + 0.01 + high]))
            x += wide + 0.002
    return [Item(joined(wood), printed(rng, WOOD, 0.15)), Item(joined(books), printed(rng, POSTER, 0.06))]


def cupboard(rng: Rng) -> list[Item]:
    """Doors with handles; a box stands on it."""
    w, d, h = 0.9, 0.42, 1.15  # always of one size: two of them in a room look alike
    body = [box([-w / 2, w / 2], [0, d], [0.06, h]), box([-w / 2 + 0.03, w / 2 - 0.03], [0, d - 0.05], [0, 0.06])]
    body += [rod(0.012, [x, d + 0.03, 0.55], [x, d + 0.03, 0.75]) for x in (-0.06, 0.06)]
    body += [box([x - 0.003, x + 0.003], [d, d + 0.012], [0.08, h]) for x in (-0.4, 0.0, 0.4)]
    top = box([-0.3, -0.3 + rng.uniform(0.2, 0.5)], [0.06, 0.34], [h, h + rng.uniform(0.12, 0.3)])
    return [Item(joined(body), printed(rng, WHITE, 0.4)), Item(top, printed(rng, POSTER, 0.1))]


def sofa(rng: Rng) -> list[Item]:
    """Soft: cushions are ellipsoids."""
    w, d = rng.uniform(1.3, 1.6), 0.75
    base = joined(
        [box([-w / 2, w / 2], [0, d], [0.08, 0.4]), box([-w / 2, w / 2], [0, 0.2], [0.4, 0.8])]
        + [box(sorted([s * w / 2, s * (w / 2 - 0.16)]), [0, d], [0.4, 0.58]) for s in (-1, 1)]
    )
    cushions = [ball([0.2, 0.08, 0.19], [x, 0.29, 0.57]) for x in np.linspace(-w / 2 + 0.38, w / 2 - 0.38, 3)]
    return [Item(base, printed(rng, CLOTH, 0.12, 0.15)), Item(joined(cushions), printed(rng, POSTER, 0.1))]


def chair(rng: Rng) -> list[Item]:
    """Seat, back and four legs; always the same."""
    parts = [box([-0.21, 0.21], [0.08, 0.5], [0.43, 0.47])]
    parts += [box([-0.2, 0.2], [0.08, 0.1], [z, z + 0.09]) for z in (0.6, 0.75)]
    parts += [rod(0.016, [x, 0.09, 0], [x, 0.09, 0.86]) for x in (-0.19, 0.19)]
    parts += [rod(0.016, [x, 0.48, 0], [x, 0.48, 0.43]) for x in (-0.19, 0.19)]
    return [Item(joined(parts), printed(rng, WOOD, 0.1))]


def lamp(rng: Rng) -> list[Item]:
    high = rng.uniform(1.4, 1.6)
    shade = trimesh.creation.cone(0.22, 0.4, sections=40)
    shade.apply_translation([0, 0.25, high])
    stand = joined([rod(0.14, [0, 0.25, 0], [0, 0.25, 0.02]), rod(0.018, [0, 0.25, 0], [0, 0.25, high])])
    return [Item(stand, printed(rng, WOOD, 0.1)), Item(shade, printed(rng, WHITE, 0.08))]


def plant(rng: Rng) -> list[Item]:
    """A pot and leaves in all directions."""
    leaves = []
    for _ in range(26):
        leaf = ball([0.14, 0.05, 0.008], [0.13, 0, 0])
        for angle, axis in zip(rng.uniform([0, -1.1, 0], [0.6, 0.3, 6.28]), np.eye(3), strict=True):
            leaf.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
        leaf.apply_translation([0, 0.24, rng.uniform(0.5, 1.1)])
        leaves.append(leaf)
    pot = trimesh.creation.cylinder(0.17, 0.36, sections=40)
    pot.apply_translation([0, 0.24, 0.18])
    stem = rod(0.02, [0, 0.24, 0.3], [0, 0.24, 1.1])
    return [Item(joined([pot, stem]), printed(rng, POSTER, 0.09)), Item(joined(leaves), printed(rng, GREEN, 0.05))]


def crates(rng: Rng) -> list[Item]:
    """Boxes piled up, each turned a little."""
    parts, z = [], 0.0
    for _ in range(int(rng.integers(2, 5))):
        w, d, h = rng.uniform([0.3, 0.25, 0.2], [0.5, 0.38, 0.36])
        one = box([-w / 2, w / 2], [-d / 2, d / 2], [0, h])
        one.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(-0.4, 0.4), [0, 0, 1]))
        one.apply_translation([rng.uniform(-0.04, 0.04), 0.34, z])
        parts.append(one)
        z += h
    return [Item(joined(parts), printed(rng, POSTER, 0.13))]


PIECES: dict[str, tuple[Callable[[Rng], list[Item]], float]] = {  # and the width [m] that each takes of a wall
    "table": (table, 1.5), "shelf": (shelf, 1.15), "cupboard": (cupboard, 1.0), "sofa": (sofa, 1.7),
    "chair": (chair, 0.55), "lamp": (lamp, 0.5), "plant": (plant, 0.7), "crates": (crates, 0.65),
}  # fmt: skip
