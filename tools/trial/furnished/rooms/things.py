"""Scenes of things before a wall: crates, a free-form sheet, boards, columns. The order of random draws is kept."""

import numpy as np
from scipy.spatial.transform import Rotation

from tools.trial.furnished.rooms.indoor import corridor, living_room, stairs
from tools.trial.furnished.rooms.parts import Array, Furnished, ScenePart, ball, box, cylinder, grid, yaw

Rng = np.random.Generator


def crates(rng: Rng) -> Furnished:
    parts = [
        grid([-1, -2.5, 0], [6, 0, 0], [0, 5, 0], (3, 3), rng.uniform(0.3, 0.7), "floor"),
        grid([3.2, -2.5, 0], [0, 5, 0], [0, 0, 3], (3, 2), rng.uniform(0.4, 0.8), "wall"),
    ]
    for i in range(rng.integers(9, 16)):
        size = rng.uniform(0.2, 0.55, 3)
        x, y = rng.uniform(1.6, 2.9), rng.uniform(-1.1, 1.1)
        centre = [x, y, rng.uniform(0.12, 1.1) * (1 - 0.3 * rng.random())]
        turned = Rotation.from_euler("zyx", [rng.uniform(0, 3), rng.normal(0, 0.25), rng.normal(0, 0.25)])
        parts.append(box(centre, size, turned, rng.uniform(0.15, 0.85), f"crate{i}", rng))
    eye = [(-0.4, 0.7), (-1.2, 1.2), (0.5, 1.8)]
    return Furnished(parts, eye, [(1.8, 2.6), (-0.6, 0.6), (0.3, 0.9)], "pile of crates")


def freeform(rng: Rng) -> Furnished:
    """A sheet bent by five waves, sometimes with things before it."""
    waves = rng.uniform(1.5, 7, (5, 2)) * rng.choice([-1, 1], (5, 2))
    phases = rng.uniform(0, 6.3, 5)
    sizes = rng.uniform(0.03, 0.13, 5) * 3 / (1 + np.hypot(*waves.T))

    def height(a: Array, b: Array) -> Array:
        each = (sizes[i] * np.sin(waves[i, 0] * a * 2.2 + waves[i, 1] * b * 2 + phases[i]) for i in range(5))
        return np.asarray(sum(each))

    patches = rng.choice([0.3, 0.5, 0.75], (9, 9)) if rng.random() < 0.6 else np.full((9, 9), 0.6)
    fine = np.kron(patches, np.ones((10, 10)))
    parts = [grid([2.2, 1.6, -0.2], [0, -3.2, 0], [0, 0, 2.6], (90, 90), fine, "sheet", height)]
    if rng.random() < 0.6:
        squares = rng.choice([0.3, 0.6], (4, 4))
        parts.append(grid([0.9, -1.3, 0.2], [1.0, -0.15, 0], [0, 0, 1.8], (4, 4), squares, "side panel"))
    if rng.random() < 0.7:
        parts.append(ball([1.55, 0.5, 0.7], 0.22, 0.5, "ball"))
    if rng.random() < 0.5:
        parts.append(box([1.5, -0.5, 0.35], [0.3, 0.4, 0.7], yaw(0.6), 0.4, "block", rng))
    eye = [(-0.3, 0.6), (-1.0, 1.0), (0.4, 1.7)]
    return Furnished(parts, eye, [(1.8, 2.2), (-0.5, 0.5), (0.6, 1.4)], "free-form sheet")


def boards(rng: Rng) -> Furnished:
    back = rng.choice([0.2, 0.45, 0.8], (5, 8))
    parts = [grid([3.6, -2.6, -0.3], [0, 5.2, 0], [0, 0, 3.2], (8, 5), back, "back wall")]
    for i in range(rng.integers(4, 7)):
        x, y, z = rng.uniform(1.2, 2.9), -1.3 + i * 0.55 + rng.normal(0, 0.1), rng.uniform(0.5, 1.6)
        centre = np.array([x, y, z])
        turned = Rotation.from_euler("zy", [rng.uniform(-1.0, 1.0), rng.uniform(-0.7, 0.7)])
        along, up = turned.apply([[0, rng.uniform(0.4, 0.8), 0], [0, 0, rng.uniform(0.4, 0.8)]])
        n = int(rng.integers(2, 7))
        squares = rng.choice([0.12, 0.4, 0.85], (n, n)) if rng.random() < 0.7 else 0.7
        parts.append(grid(centre - along / 2 - up / 2, along, up, (n, n), squares, f"board{i}"))
    eye = [(-0.3, 0.5), (-0.9, 0.9), (0.6, 1.5)]
    return Furnished(parts, eye, [(1.8, 3.0), (-0.7, 0.7), (0.8, 1.3)], "tilted boards")


def columns(rng: Rng) -> Furnished:
    parts = [
        grid([-1, -2.4, 0], [6, 0, 0], [0, 4.8, 0], (6, 6), rng.choice([0.3, 0.6], (6, 6)), "floor"),
        grid([3.8, -2.4, 0], [0, 4.8, 0], [0, 0, 2.8], (2, 2), 0.65, "wall"),
    ]
    for i in range(rng.integers(4, 8)):
        place = [rng.uniform(1.4, 3.4), rng.uniform(-1.4, 1.4)]
        radius = rng.uniform(0.05, 0.25)
        if rng.random() < 0.65:
            parts.append(cylinder([*place, 0.9], radius, 1.8, rng.uniform(0.2, 0.85), f"column{i}"))
        else:
            centre = [*place, rng.uniform(0.4, 1.5)]
            parts.append(ball(centre, radius + 0.1, rng.uniform(0.2, 0.85), f"ball{i}"))
    eye = [(-0.4, 0.4), (-1.0, 1.0), (0.6, 1.7)]
    return Furnished(parts, eye, [(1.8, 3.0), (-0.7, 0.7), (0.5, 1.2)], "columns and balls")


# the order is part of what a seed makes: a scene is drawn by its place in here
ROOMS = {
    "living": living_room,
    "stairs": stairs,
    "crates": crates,
    "freeform": freeform,
    "boards": boards,
    "columns": columns,
    "corridor": corridor,
}
SHELL = ("wall", "floor", "ceil", "sheet", "side", "left", "right")


def things(scene: list[ScenePart]) -> list[int]:
    """Indices of the parts that stand in the room and are not the room."""
    return [i for i, one in enumerate(scene) if not any(word in one.name for word in SHELL)]
