"""What is scanned, what it stands on, and what is in the way: meshes, and paint that is a function of the place."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.planted.shapes import BRIGHT, PLAIN, SHAPES, WOOD, joined, waves
from tools.sets.planted.stage import Solid

Array = NDArray[np.float64]
Rng = np.random.Generator

SKIN = ((214, 170, 140), (200, 156, 126))
CLOTH = ((52, 60, 84), (60, 70, 96), (80, 44, 50))
BLACK = ((30, 30, 32), (40, 40, 40))


@dataclass(frozen=True)
class Print:
    """Colours (r, g, b) by the sign of smooth random fields, coarse, middle and fine."""

    fields: tuple[Any, ...]
    palette: Array
    contrast: float

    def at(self, points: Array) -> Array:
        """(n, 3) colours, 0 to 255, of points (n, 3)."""
        coarse, middle, fine = (field.at(points) for field in self.fields)
        index = (np.floor(1.2 * coarse).astype(int) + 2 * (middle > 1.0)) % len(self.palette)
        shade = 0.85 + self.contrast * (0.2 * np.sign(middle) + 0.12 * np.clip(fine, -2, 2))
        return np.asarray(self.palette[index] * shade[:, None])


@dataclass(frozen=True)
class Thing:
    """A solid with its paint."""

    solid: Solid
    paint: Print


def printed(
    rng: Rng, palette: tuple[tuple[int, int, int], ...] = BRIGHT, size: float = 0.05, contrast: float = 1.0
) -> Print:
    """Patches of about `size` metres with finer marks upon them."""
    return Print((waves(rng, size), waves(rng, size / 3), waves(rng, 0.006)), np.array(palette, float), contrast)


def plain(rng: Rng, grey: float = 190.0) -> Print:
    """One colour."""
    return Print((waves(rng, 1), waves(rng, 1), waves(rng, 1)), np.full((1, 3), grey), 0.0)


def thing(mesh: trimesh.Trimesh, paint: Print) -> Thing:
    return Thing(Solid(mesh), paint)


def shape(rng: Rng, kind: str, height: float) -> trimesh.Trimesh:
    """One of box, sphere, cylinder, lumpy, tower, bricks: stands at z = 0, about the origin."""
    if kind == "box":
        mesh = trimesh.creation.box([height * rng.uniform(0.5, 0.8), height * rng.uniform(0.25, 0.45), height])
        return lifted(mesh)
    if kind == "sphere":
        return lifted(trimesh.creation.icosphere(subdivisions=5, radius=0.42 * height))
    if kind == "cylinder":
        return lifted(trimesh.creation.cylinder(0.28 * height, height, sections=180))
    return SHAPES[kind](rng, height)


def lifted(mesh: trimesh.Trimesh, height: float = 0.0) -> trimesh.Trimesh:
    """Its lowest point at `height`."""
    mesh.apply_translation([0, 0, height - mesh.bounds[0, 2]])
    return mesh


def support(rng: Rng, kind: str, radius: float) -> trimesh.Trimesh | None:
    """What turns below the object, its top at z = 0: disc, square or odd plate; None if it is turned itself."""
    thick = rng.uniform(0.006, 0.025)
    if kind == "disc":
        mesh = trimesh.creation.cylinder(radius, thick, sections=96)
    elif kind == "square":
        mesh = trimesh.creation.box([1.8 * radius, rng.uniform(1.4, 1.8) * radius, thick])
        mesh.apply_translation([*rng.uniform(-0.1, 0.1, 2) * radius, 0])
    elif kind == "odd":
        some = rng.uniform(0.75, 1.15, 7) * radius
        around = np.sort(rng.uniform(-0.25, 0.25, 7) + np.arange(7) * 2 * np.pi / 7)
        flat = np.stack([some * np.cos(around), some * np.sin(around)], axis=1)
        points = np.concatenate([np.c_[flat, np.zeros(7)], np.c_[flat, np.full(7, -thick)]])
        mesh = trimesh.convex.convex_hull(points)
    else:
        return None
    mesh.apply_translation([0, 0, -mesh.bounds[1, 2]])
    return mesh


def surroundings(rng: Rng, behind: float, floor: float) -> Thing:
    """A table top at height `floor`, the room's floor, and a wall or board `behind` metres along +y."""
    desk = trimesh.creation.box([1.6, 1.6, 0.03])
    desk.apply_translation([0, min(behind, 0.8) - 0.8, floor - 0.015])
    ground = trimesh.creation.box([8, 8, 0.02])
    ground.apply_translation([0, 0, floor - 0.75])
    size = (8, 6) if behind > 0.6 or rng.random() < 0.5 else tuple(rng.uniform(0.5, 0.9, 2))
    wall = trimesh.creation.box([size[0], 0.02, size[1]])
    wall.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(-0.12, 0.12), [0, 0, 1]))
    wall.apply_translation([0, behind + 0.01, floor + (size[1] / 2 if size[1] < 6 else 0)])
    parts = [desk, ground, wall]
    if size[1] < 6:  # a board before a wall far behind
        far = trimesh.creation.box([8, 0.02, 6])
        far.apply_translation([0, behind + rng.uniform(0.8, 1.6), 0])
        parts.append(far)
    for _ in range(int(rng.integers(0, 3))):
        extra = trimesh.creation.box(rng.uniform([0.05, 0.05, 0.08], [0.12, 0.1, 0.2]))
        extra.apply_translation([rng.choice([-1, 1]) * rng.uniform(0.33, 0.5), rng.uniform(-0.1, 0.1), 0])
        parts.append(lifted(extra, floor))
    return thing(joined(parts), printed(rng, PLAIN if rng.random() < 0.6 else WOOD, 0.25, 0.4))


def hand(rng: Rng) -> Thing:
    """A hand with a forearm; its fingertips at the origin, the arm along +x."""
    palm = trimesh.creation.icosphere(subdivisions=3)
    palm.apply_scale([0.05, 0.04, 0.02])
    palm.apply_translation([0.11, 0, 0])
    fingers = [trimesh.creation.capsule(0.06, 0.008) for _ in range(4)]
    for i, finger in enumerate(fingers):
        finger.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
        finger.apply_translation([0.01, 0.018 * (i - 1.5), 0])
    arm = trimesh.creation.capsule(0.4, 0.036)
    arm.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    arm.apply_translation([0.15, 0, 0.01])
    return thing(joined([palm, arm, *fingers]), printed(rng, SKIN, 0.1, 0.3))


def person(rng: Rng, floor: float) -> Thing:
    """A body and a head, standing on the room's floor, about the origin."""
    body = trimesh.creation.icosphere(subdivisions=3)
    body.apply_scale([0.25, 0.15, 0.75])
    head = trimesh.creation.icosphere(subdivisions=3, radius=0.12)
    head.apply_translation([0, 0, 0.88])
    return thing(lifted(joined([body, head]), floor - 0.75), printed(rng, CLOTH, 0.3, 0.5))


def cable(rng: Rng, start: Array, floor: float) -> Thing:
    """A cable that lies on the table from near the plate to its edge."""
    end = start * 3.2
    bow = rng.uniform(-0.15, 0.15)
    t = np.linspace(0, 1, 14)[:, None]
    side = np.array([-start[1], start[0]]) / np.linalg.norm(start)
    path = start + t * (end - start) + bow * np.sin(np.pi * t) * side
    pieces = []
    for a, b in pairwise(path):
        ends = [[*a, floor + 0.006], [*b, floor + 0.006]]
        pieces.append(trimesh.creation.cylinder(0.005, segment=ends, sections=10))
    return thing(joined(pieces), printed(rng, BLACK, 0.3, 0.2))
