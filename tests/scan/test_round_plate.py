"""A plate that stays in the mesh is cut as it is: round."""

from types import SimpleNamespace

import numpy as np

from fusion.mesh.mesh import Mesh
from fusion.scan.cleaning.clean import clean
from fusion.scan.finding.object import MARGIN
from fusion.scan.settings import ScanSettings


def square(half: float, cells: int = 60) -> Mesh:
    """What a volume with square bounds shows of a large plate."""
    side = np.linspace(-half, half, cells + 1)
    x, y = (part.ravel() for part in np.meshgrid(side, side))
    i = np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)
    a, b, c, d = (part.ravel() for part in (i, i + 1, i + cells + 1, i + cells + 2))
    faces = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])]).astype(np.int32)
    points = np.column_stack([x, y, np.zeros_like(x)])
    return Mesh(points, faces, np.tile(np.float32([0, 0, 1]), (len(points), 1)))


def test_the_plate_stays_round():
    motion = SimpleNamespace(plate=0.0, radius=0.15)
    kept = clean(square(0.15 + MARGIN), ScanSettings(keep_plate=True, fill_holes=0), motion, 0.002).mesh
    x, y, _ = kept.vertices.T
    turned = (x + y) / np.sqrt(2)
    cell = 2 * (0.15 + MARGIN) / 60
    assert np.hypot(x, y).max() <= 0.15 + MARGIN
    # a square would reach 1.41 times as far along its diagonal
    assert abs(turned.max() - x.max()) < cell * np.sqrt(2)
