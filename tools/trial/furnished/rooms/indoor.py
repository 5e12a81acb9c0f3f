"""Rooms with walls around: a living room, stairs, a corridor. The order of random draws is what a seed makes."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tools.trial.furnished.rooms.parts import Furnished, ScenePart, ball, box, cylinder, grid, yaw

Rng = np.random.Generator


def living_room(rng: Rng) -> Furnished:
    length, width, height = rng.uniform(3.4, 4.6), rng.uniform(3, 4), rng.uniform(2.3, 2.7)
    parts = _shell(rng, length, width, height)

    def grey() -> float:
        return rng.uniform(0.15, 0.85)

    for i in range(rng.integers(4, 8)):
        size = rng.uniform([0.3, 0.3, 0.3], [1.2, 0.7, 1.3])
        centre = [rng.uniform(1.8, length - 0.3), rng.uniform(0.3, width - 0.3), size[2] / 2]
        parts.append(box(centre, size, yaw(rng.uniform(0, 3.14)), grey(), f"cabinet{i}", rng))
    foot = [rng.uniform(2, length - 0.4), rng.uniform(0.5, width - 0.5), 0.55]
    parts.append(cylinder(foot, 0.17, 1.1, grey(), "column"))
    centre = [rng.uniform(2, length - 0.5), rng.uniform(0.6, width - 0.6), rng.uniform(0.9, 1.6)]
    parts.append(ball(centre, rng.uniform(0.15, 0.3), grey(), "ball"))
    eye = [(0.35, 1.3), (0.5, width - 0.5), (0.7, 1.7)]
    return Furnished(parts, eye, [(length - 1.4, length), (0.4, width - 0.4), (0.3, 1.5)], "living room")


def stairs(rng: Rng) -> Furnished:
    parts = [grid([-1, -2, 0], [6, 0, 0], [0, 4, 0], (4, 4), rng.choice([0.3, 0.5, 0.7], (4, 4)), "floor")]
    steps, tread, rise = rng.integers(5, 9), rng.uniform(0.24, 0.32), rng.uniform(0.14, 0.2)
    first = rng.uniform(1.3, 1.8)
    for i in range(steps):
        centre = [first + tread * (i + 0.5), 0, rise * (i + 1) / 2]
        parts.append(box(centre, [tread, 1.6, rise * (i + 1)], yaw(0), rng.uniform(0.3, 0.8), f"step{i}"))
    last = first + tread * steps
    parts.append(grid([last, -2, 0], [0, 4, 0], [0, 0, 3], (5, 4), rng.choice([0.25, 0.5, 0.8], (4, 5)), "wall"))
    parts.append(grid([-1, 1.4, 0], [6, 0, 0], [0, 0, 3], (3, 2), 0.6, "side"))
    angle = rng.uniform(0.3, 0.9)
    along = [0.7 * np.cos(angle), 0.7 * np.sin(angle), 0]
    squares = rng.choice([0.2, 0.5, 0.85], (6, 6))
    parts.append(grid([first - 0.1, -1.7, 0.1], along, [0.25, -0.1, 1.1], (6, 6), squares, "board"))
    parts.append(cylinder([first + 0.1, 1.1, 0.5], 0.06, 1.0, 0.5, "post"))
    lying = Rotation.from_euler("xyz", [1.3, 0.2, 0.4])
    parts.append(cylinder([first + 0.7, -0.4, rise * 3 + 0.2], 0.12, 0.9, 0.45, "log", lying))
    eye = [(-0.4, 0.5), (-1, 1), (0.7, 1.8)]
    return Furnished(parts, eye, [(first, last), (-0.8, 0.8), (0.2, 1.2)], "stairs")


def corridor(rng: Rng) -> Furnished:
    width, height = rng.uniform(1.6, 2.4), 2.4
    low, left, right = [-1, -width / 2, 0], [-1, -width / 2, 0], [-1, width / 2, 0]
    ahead, across, up = [6, 0, 0], [0, width, 0], [0, 0, height]
    parts = [
        grid(low, ahead, across, (8, 3), rng.choice([0.35, 0.6], (3, 8)), "floor"),
        grid([-1, -width / 2, height], ahead, across, (1, 1), 0.8, "ceiling"),
        grid(left, ahead, up, (6, 2), rng.choice([0.3, 0.7], (2, 6)), "left"),
        grid(right, ahead, up, (1, 1), 0.6, "right"),
        grid([4.6, -width / 2, 0], across, up, (7, 7), rng.choice([0.15, 0.4, 0.85], (7, 7)), "end wall"),
    ]
    for i in range(3):
        centre = [rng.uniform(2, 4.2), rng.choice([-1, 1]) * (width / 2 - 0.2), rng.uniform(0.3, 0.6)]
        size, turned = rng.uniform(0.25, 0.5, 3), yaw(rng.uniform(0, 1.5))
        parts.append(box(centre, size, turned, rng.uniform(0.2, 0.8), f"case{i}", rng))
    eye = [(-0.6, 2.0), (-0.4, 0.4), (0.8, 1.5)]
    return Furnished(parts, eye, [(4.4, 4.6), (-0.5, 0.5), (0.8, 1.5)], "corridor")


def _shell(rng: Rng, length: float, width: float, height: float) -> list[ScenePart]:
    """Floor, ceiling and four walls, each plain or in patches."""

    def wall(corner: Any, along: Any, up: Any, name: str) -> ScenePart:
        if rng.random() < 0.5:
            nx, ny = int(rng.integers(3, 9)), int(rng.integers(2, 6))
            return grid(corner, along, up, (nx, ny), rng.choice([0.18, 0.35, 0.6, 0.85], (ny, nx)), name)
        return grid(corner, along, up, (2, 2), rng.uniform(0.35, 0.85), name)

    x, y, z = [length, 0, 0], [0, width, 0], [0, 0, height]
    return [
        wall([0, 0, 0], x, y, "floor"),
        wall(z, x, y, "ceiling"),
        wall([0, 0, 0], x, z, "wall_s"),
        wall(y, x, z, "wall_n"),
        wall([0, 0, 0], y, z, "wall_w"),
        wall(x, y, z, "wall_e"),
    ]
