"""A statue: a foot, a body, shoulders, a head and arms of balls that lie in one another."""

from typing import Any

import numpy as np
import trimesh


def statue(rng: np.random.Generator, height: float) -> trimesh.Trimesh:
    """Stands at z = 0, flat below; each ball closed, so that what is hidden in others is never seen."""
    lean = rng.uniform(-0.05, 0.05, 2)
    parts = [(0.0, 0.0, 0.05, 0.24, 0.22, 0.09)]  # centre, half axes; of a height of one
    parts += [(*lean, 0.34, rng.uniform(0.14, 0.18), rng.uniform(0.10, 0.14), 0.30)]
    parts += [(*(1.4 * lean), 0.58, rng.uniform(0.19, 0.24), rng.uniform(0.11, 0.14), 0.14)]
    head = 1.8 * lean + rng.uniform(-0.02, 0.02, 2)
    parts += [(*head, 0.85, 0.10, 0.11, 0.15), (head[0], head[1] - 0.10, 0.84, 0.03, 0.05, 0.03)]
    for side in (-1, 1):
        reach, low = rng.uniform(0.10, 0.2), rng.uniform(0.25, 0.55)
        for t in np.linspace(0, 1, 5):
            x = side * (0.20 + 0.05 * np.sin(np.pi * t)) + 1.4 * lean[0] * (1 - t)
            parts.append((x, -reach * t, 0.6 + (low - 0.6) * t, 0.06, 0.06, 0.075))
    for _ in range(7):  # folds of the cloth
        way = rng.standard_normal(3)
        way /= np.linalg.norm(way)
        parts.append((*(0.12 * way[:2] + lean), 0.36 + 0.24 * way[2], *rng.uniform(0.05, 0.08, 3)))
    balls = []
    for part in parts:
        ball = trimesh.creation.icosphere(subdivisions=4)
        vertices = np.asarray(ball.vertices) * part[3:] + part[:3]
        vertices[:, 2] = np.maximum(vertices[:, 2], 0)
        balls.append(trimesh.Trimesh(vertices * height, ball.faces, process=False))
    whole: Any = trimesh.util.concatenate(balls)
    return trimesh.Trimesh(whole.vertices, whole.faces, process=False)
