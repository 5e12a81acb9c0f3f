"""Closed, painted objects of 10 to 30 cm with relief all round, each from its random numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator

BRIGHT = ((196, 60, 48), (232, 190, 80), (60, 120, 180), (225, 220, 205), (70, 140, 90), (120, 80, 140))
WOOD = ((150, 112, 74), (164, 124, 84), (138, 102, 66))
PLAIN = ((205, 200, 190), (198, 194, 186))  # walls and table tops show little


@dataclass(frozen=True)
class Waves:
    """A smooth random field: cosines of position with wave vectors (k, 3) [rad/m] and phases (k,)."""

    vectors: Array
    phases: Array

    def at(self, points: Array) -> Array:
        out = np.zeros(points.shape[:-1])
        for vector, phase in zip(self.vectors, self.phases, strict=True):
            out += np.cos(points @ vector + phase)
        return out


def waves(rng: Rng, length: float, count: int = 5) -> Waves:
    """Waves of about `length` metres in all directions."""
    vectors = rng.standard_normal((count, 3))
    vectors *= 2 * np.pi / length / np.linalg.norm(vectors, axis=1, keepdims=True)
    return Waves(vectors, rng.uniform(0, 2 * np.pi, count))


@dataclass(frozen=True)
class Paint:
    """Patches of a palette with a fine grain."""

    patches: Waves
    grain: Waves
    palette: tuple[tuple[int, int, int], ...]

    def at(self, points: Array) -> Array:
        """Colours (..., 3), 0 to 255."""
        index = np.floor(self.patches.at(points) * 1.3).astype(int) % len(self.palette)
        return np.asarray(
            np.array(self.palette, float)[index] * (0.85 + 0.06 * np.clip(self.grain.at(points), -2, 2))[..., None]
        )


def paint(rng: Rng, palette: tuple[tuple[int, int, int], ...], patch: float) -> Paint:
    """Patches of about `patch` metres."""
    return Paint(waves(rng, patch), waves(rng, 0.009), palette)


def lumpy(rng: Rng, height: float) -> trimesh.Trimesh:
    """A ball with bumps and dents, cut flat below."""
    ball = trimesh.creation.icosphere(subdivisions=5)
    way = np.asarray(ball.vertices, float)
    radius = np.ones(len(way))
    for _ in range(14):
        centre = rng.standard_normal(3)
        centre /= np.linalg.norm(centre)
        radius += rng.choice([-0.22, 0.35]) * rng.uniform(0.5, 1) * np.exp((way @ centre - 1) / rng.uniform(0.03, 0.12))
    points = way * radius[:, None] * [1, rng.uniform(0.7, 0.95), rng.uniform(1.1, 1.5)]
    low, high = points[:, 2].min(), points[:, 2].max()
    points[:, 2] = np.maximum(points[:, 2] - low - 0.15 * (high - low), 0)
    return trimesh.Trimesh(points * height / points[:, 2].max(), ball.faces, process=False)


def tower(rng: Rng, height: float) -> trimesh.Trimesh:
    """A bent column whose lobed cross-section twists and swells with height."""
    around, up = 144, 96
    phi = np.arange(around) * 2 * np.pi / around
    h = np.linspace(0, 1, up)[:, None]
    swell = 1 + 0.2 * np.cos(2 * np.pi * h * rng.uniform(0.9, 1.6) + rng.uniform(0, 6))
    lobes = np.zeros((up, around))
    for m, size in ((2, 0.16), (3, 0.13), (5, 0.05)):
        lobes += size * rng.uniform(0.7, 1.2) * np.cos(m * (phi + rng.uniform(-0.5, 0.5) * h) + rng.uniform(0, 6))
    radius = 0.3 * swell * (1 + lobes)
    bend = 0.12 * np.sin(np.pi * h * rng.uniform(0.8, 1.4))
    x, y = radius * np.cos(phi) + bend, radius * np.sin(phi) - 0.5 * bend
    rings = np.stack([x, y, np.broadcast_to(h, x.shape)], axis=-1).reshape(-1, 3)
    caps = np.array([[x[0].mean(), y[0].mean(), 0], [x[-1].mean(), y[-1].mean(), 1]])
    i, j = np.meshgrid(np.arange(up - 1), np.arange(around), indexing="ij")
    a, b = (i * around + j).ravel(), (i * around + (j + 1) % around).ravel()
    sides = np.concatenate([np.stack([a, b, a + around], 1), np.stack([b, b + around, a + around], 1)])
    ring, after = np.arange(around), (np.arange(around) + 1) % around
    bottom = np.stack([np.full(around, up * around), after, ring], 1)
    top = np.stack([np.full(around, up * around + 1), ring + (up - 1) * around, after + (up - 1) * around], 1)
    return trimesh.Trimesh(np.vstack([rings, caps]) * height, np.vstack([sides, bottom, top]), process=False)


def bricks(rng: Rng, height: float) -> trimesh.Trimesh:
    """Boxes of different sizes, piled and turned; each closed, in one another by a millimetre."""
    parts, level, sunk = [], 0.0, 0.001
    for share, width in ((0.35, 0.8), (0.4, 0.55), (0.25, 0.35)):
        extents = height * np.array([width * rng.uniform(0.9, 1.1), width * rng.uniform(0.55, 0.75), share])
        box = trimesh.creation.box(extents + np.array([0, 0, sunk]))
        box.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0.2, 1.3), [0, 0, 1]))
        shift = height * rng.uniform(-0.06, 0.06, 2)
        box.apply_translation([*shift, level + (extents[2] + sunk) / 2 - sunk * bool(level)])
        parts.append(box)
        level += extents[2]
    annex = trimesh.creation.box(height * np.array([0.3, 0.25, 0.5]))
    annex.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0, 1.5), [0, 0, 1]))
    annex.apply_translation(height * np.array([0.42, rng.uniform(-0.15, 0.15), 0.25]))
    return joined([*parts, annex])


def joined(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh of several."""
    whole: Any = trimesh.util.concatenate(parts)
    return trimesh.Trimesh(whole.vertices, whole.faces, process=False)


SHAPES: dict[str, Callable[[Rng, float], trimesh.Trimesh]] = {"lumpy": lumpy, "tower": tower, "bricks": bricks}
