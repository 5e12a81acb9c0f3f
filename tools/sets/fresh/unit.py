"""Draws a unit: lens, device, table, object, how the table turns and what its log says."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.fresh import dots, flight, lens
from tools.sets.fresh.dots import Dots
from tools.sets.fresh.flight import Flight
from tools.sets.fresh.lens import Lens
from tools.sets.fresh.statue import statue
from tools.sets.fresh.views import Table
from tools.sets.planted.shapes import SHAPES, waves
from tools.sets.planted.stage import Solid

Array = NDArray[np.float64]
Rng = np.random.Generator

NOMINAL = {
    "itof": Lens(256, 212, 182.5, 182.5, 127.5, 105.5),
    "structured_light": Lens(320, 240, 285.63, 285.63, 159.5, 119.5),
}
LASER = 0.0007  # [m], standard deviation of a measured distance
THICK = 0.012  # [m] of the disc


@dataclass(frozen=True)
class Turning:
    """Angles [rad] (n,), right-handed about the axis that points up: true, and as logged; the axis in the disc's frame.

    A slip is in the true angles and not in the log; its frame is the first after it, -1 without.
    """

    true: Array
    logged: Array
    point: Array
    direction: Array
    slip: int

    def pose(self, i: int) -> Array:
        """(4, 4) that turns the disc from its first place to that of frame i, in its frame."""
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec((self.true[i] - self.true[0]) * self.direction).as_matrix()
        T[:3, 3] = self.point - T[:3, :3] @ self.point
        return T


@dataclass(frozen=True)
class Unit:
    """All that is drawn; `T` (4, 4) is the camera in the disc's frame at the first frame."""

    name: str
    device: Flight | Dots
    shape: str
    table: Table
    turning: Turning
    walls: Array

    def poses(self) -> Array:
        """(n, 4, 4) camera in the disc's frame."""
        count = len(self.turning.true)
        return np.array([np.linalg.inv(self.turning.pose(i)) @ self.table.T for i in range(count)])


def drawn(kind: str, shape: str, name: str, rng: Rng) -> Unit:
    """A unit of a kind ("itof" or "structured_light") that scans a "statue" or "blocks"."""
    own = lens.drawn(rng, NOMINAL[kind])
    device: Any = (flight if kind == "itof" else dots).drawn(rng, own)
    height = rng.uniform(0.26, 0.38)
    item = statue(rng, height) if shape == "statue" else SHAPES["bricks"](rng, height)
    item.apply_translation([*rng.uniform(-0.02, 0.02, 2), 0.0])
    radius = float(np.linalg.norm(item.vertices[:, :2], axis=1).max()) + rng.uniform(0.02, 0.05)
    plate = trimesh.creation.cylinder(radius, THICK, sections=128)
    plate.apply_translation([0, 0, -THICK / 2])
    table = Table(Solid(plate), Solid(item), waves(rng, 0.12), camera(rng, height, radius))
    turning = turned(rng)
    walls = np.linspace(0.6, rng.uniform(1.5, 1.9), int(rng.integers(6, 11))) + rng.uniform(-0.02, 0.02)
    return Unit(name, device, shape, table, turning, walls)


def camera(rng: Rng, height: float, radius: float) -> Array:
    """A camera that looks down on the object from 0.75 m and more."""
    down, around = np.deg2rad(rng.uniform(15, 32)), rng.uniform(0, 2 * np.pi)
    aim = np.array([*rng.uniform(-0.02, 0.02, 2), 0.42 * height])
    far = rng.uniform(0.6, 0.8) + 0.5 * max(height, radius)
    centre = aim + far * np.array([np.cos(around) * np.cos(down), np.sin(around) * np.cos(down), np.sin(down)])
    forward = (aim - centre) / far
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    roll = Rotation.from_rotvec(np.deg2rad(rng.uniform(-3, 3)) * forward).as_matrix()
    T = np.eye(4)
    T[:3, :3] = roll @ np.column_stack([right, np.cross(forward, right), forward])
    T[:3, 3] = centre
    return T


def turned(rng: Rng) -> Turning:
    """40 to 80 frames over 1 to 2.2 turns; the log is off by a degree or so, and by a slip in two of five."""
    count, turns = int(rng.integers(40, 81)), rng.uniform(1.02, 2.2)
    said = np.linspace(0, 2 * np.pi * turns, count)
    wave = rng.uniform(0.2, 0.8) * np.sin(said + rng.uniform(0, 6)) + rng.uniform(0, 0.3) * np.sin(2 * said)
    off = np.deg2rad(wave + rng.uniform(0.1, 0.4) * rng.standard_normal(count))
    slip = int(rng.integers(count // 4, 3 * count // 4)) if rng.random() < 0.4 else -1
    if slip > 0:
        off[slip:] += np.deg2rad(rng.choice([-1, 1]) * rng.uniform(3, 8))
    way = rng.choice([-1, 1])
    direction = np.array([*rng.uniform(-0.03, 0.03, 2), 1.0])
    point = np.array([*rng.uniform(-0.012, 0.012, 2), 0.0])
    return Turning(way * (said + off), way * said, point, direction / np.linalg.norm(direction), slip)
