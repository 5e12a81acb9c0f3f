"""Light that reaches a surface by way of another one, as phasors of its own."""

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.rays import Panel
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]

LIGHT = 299_792_458.0
SAMPLES = 10  # along each edge of a panel


def second_bounce(shot: Shot, light: NDArray[np.complex128], modulations: Array) -> NDArray[np.complex128]:
    """(f, h, w) what is added to the light of every pixel: lamp - other panel - surface - lens."""
    if "bounce" not in shot.kept:
        shot.kept["bounce"] = _bounced(shot, light, modulations)
    return np.asarray(shot.kept["bounce"])


def _bounced(shot: Shot, light: NDArray[np.complex128], modulations: Array) -> NDArray[np.complex128]:
    out = np.zeros_like(light)
    origin = shot.T[:3, 3]
    seen = shot.hits
    own = np.maximum(np.abs(light[0]), 1e-9)
    for i, panel in enumerate(shot.panels):
        pixels = seen.panel == i
        X = seen.points[pixels]
        r = np.linalg.norm(X - origin, axis=-1)
        cosine = np.maximum(seen.cosine[pixels], 0.05)
        for j, other in enumerate(shot.panels):
            if i == j or not len(X):
                continue
            for Y, power in _lit(other, origin):
                way = Y - X
                d2 = np.maximum((way**2).sum(axis=-1), 1e-3)
                d, ry = np.sqrt(d2), np.linalg.norm(Y - origin)
                form = np.abs(way @ other.normal) * np.abs(way @ panel.normal) / d2 / (np.pi * d2)
                # relative to what the lamp itself brings to the surface: cosine / r^2
                share = power * form * r**2 / cosine
                phase = 2 * np.pi * modulations[:, None] * (ry + d + r) / LIGHT
                out[:, pixels] += own[pixels] * share * np.exp(1j * phase)
    return out


def _lit(panel: Panel, origin: Array) -> list[tuple[Array, float]]:
    """Points (3,) of a panel and the light that each sends on."""
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES
    area = float(np.linalg.norm(np.cross(panel.a, panel.b))) / SAMPLES**2
    rows, columns = panel.cells.shape
    out = []
    for s in steps:
        for t in steps:
            Y = panel.corner + s * panel.a + t * panel.b
            away = Y - origin
            r = float(np.linalg.norm(away))
            rho = float(panel.cells[int(t * rows), int(s * columns)])
            out.append((Y, rho * abs(float(away @ panel.normal)) / r**3 * area))
    return out
