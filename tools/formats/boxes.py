"""A scene of known size without any symmetry, and the cameras that see it; no formula of the program is in it.

A corner of three walls that lean in their own ways and a box of 300 x 200 x 240 mm that stands askew before them, so
that no surface is square to an axis. World: x right, y down, z away from the viewer, metres.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tools.formats.take import Array, Lens, Take

BOX = np.array([0.30, 0.20, 0.24])  # edges [m]
BOX_TURN = Rotation.from_euler("xyz", [31, -37, 12], degrees=True).as_matrix()
BOX_CENTRE = np.array([0.07, -0.03, 0.92])
# n . p = d, n towards the viewer
_WALLS = [([-0.25, 0.18, -1.0], -1.25), ([0.9, 0.1, -0.55], -0.95), ([-0.1, -1.0, -0.45], -0.85)]
STEP_S, START = 1 / 30, 12.5


@dataclass(frozen=True)
class Plane:
    """n . p = d in the world."""

    n: Array
    d: float


def planes() -> list[Plane]:
    """Three walls, then the box's six faces."""
    walls = [Plane(np.array(n) / np.linalg.norm(n), d / float(np.linalg.norm(n))) for n, d in _WALLS]
    faces = []
    for axis in range(3):
        for side in (1.0, -1.0):
            n = side * BOX_TURN[:, axis]
            faces.append(Plane(n, float(n @ BOX_CENTRE) + BOX[axis] / 2))
    return walls + faces


def way(count: int) -> Array:
    """(count, 4, 4) camera to world: it goes aside, up and near, and turns about all axes."""
    made = []
    for i in range(count):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_euler("xyz", [3 * i - 4, 2 - 4 * i, 2.5 * i], degrees=True).as_matrix()
        T[:3, 3] = [0.06 * i - 0.05, 0.03 - 0.025 * i, 0.02 * i]
        made.append(T)
    return np.stack(made)


def seen(rays: Array, T: Array) -> tuple[Array, Array]:
    """(h, w) depth along the axis [m], 0 where nothing is, and the plane that is seen, -1 where none is."""
    aim = np.dstack([rays, np.ones(rays.shape[:2])]) @ T[:3, :3].T
    eye = T[:3, 3]
    best, which = np.full(rays.shape[:2], np.inf), np.full(rays.shape[:2], -1)
    walls = 3
    for index, plane in enumerate(planes()):
        across = aim @ plane.n
        with np.errstate(divide="ignore", invalid="ignore"):
            z = (plane.d - plane.n @ eye) / across
        hit = (across < 0) & (z > 0)
        if index >= walls:
            inside = (eye + aim * np.where(hit, z, 0)[..., None] - BOX_CENTRE) @ BOX_TURN
            hit &= (np.abs(inside) <= BOX / 2 + 1e-9).all(axis=-1)
        elif walls:  # the walls are the inner side of a hollow: the nearest of them is seen
            hit &= z < 5
        nearer = hit & (z < best)
        best, which = np.where(nearer, z, best), np.where(nearer, index, which)
    return np.where(np.isfinite(best), best, 0.0), which


def taken(lens: Lens, count: int = 4, unit: float = 0.001, rays: Array | None = None, still: bool = False) -> Take:
    """The scene by a camera; `rays` where a library says them, NaN where it has none; `still`: it never moves."""
    given = lens.rays() if rays is None else rays
    poses = np.repeat(way(1), count, axis=0) if still else way(count)
    blind = ~np.isfinite(given[..., 0])
    depth = np.stack([np.where(blind, 0, seen(np.nan_to_num(given), T)[0]) for T in poses])
    stamps = START + STEP_S * np.arange(count) + np.where(np.arange(count) == 2, 0.004, 0.0)  # not quite even
    color = np.stack([ramp(lens, i) for i in range(count)])
    return Take(lens, depth, stamps, color, lens, poses=None if still else poses, unit=unit)


def ramp(lens: Lens, frame: int) -> np.ndarray:
    """(h, w, 3) RGB in which red tells the column and green the row; soft, so that JPEG keeps it."""
    v, u = np.mgrid[: lens.height, : lens.width]
    red, green = 20 + 200 * u / lens.width, 20 + 200 * v / lens.height
    return np.rint(np.stack([red, green, np.full(u.shape, 60 + 10 * frame)], axis=-1)).astype(np.uint8)
