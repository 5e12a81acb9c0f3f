"""The two workloads: a knotted tube on a circle of cameras, and a furnished room; exact shapes, numpy only.

Depth is planar z, rounded to millimetres as uint16, 0 where nothing is met; pixel (0, 0) is the centre of the
top-left pixel, as in fusion. No noise, so that errors are those of the method.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tools.benchmarks.stages import knot, room

WIDTH, HEIGHT, FOCAL = 640, 480, 570.0
CENTRE = (319.5, 239.5)


@dataclass(frozen=True)
class Workload:
    """How a scene is fused: voxel, truncation, largest depth [m], and a box around it."""

    name: str
    voxel: float
    truncation: float
    far: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]


OBJECT = Workload("object", 0.002, 0.008, 2.0, (-0.18, -0.18, -0.18), (0.18, 0.18, 0.18))
ROOM = Workload("room", 0.008, 0.032, 5.0, (-0.1, -0.1, -0.1), (4.1, 4.1, 2.6))
WORKLOADS = {w.name: w for w in (OBJECT, ROOM)}


def made(name: str, cache: Path) -> Path:
    """The file of a workload (depth, poses, matrix, settings), made when it is not there yet."""
    path = cache / f"{name}-1.npz"  # the number goes up when the scene changes
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        images, poses = _object() if name == "object" else _room()
        K = np.array([[FOCAL, 0, CENTRE[0]], [0, FOCAL, CENTRE[1]], [0, 0, 1.0]])
        w = WORKLOADS[name]
        partial = path.with_suffix(".partial.npz")
        np.savez(
            partial, depth=np.round(np.stack(images) * 1000).astype(np.uint16), poses=np.stack(poses), K=K, name=name,
            voxel=w.voxel, truncation=w.truncation, far=w.far, low=np.array(w.low), high=np.array(w.high),
        )  # fmt: skip
        partial.rename(path)
    return path


def _rays() -> NDArray[np.float64]:
    """(h, w, 3) directions with z = 1."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    return np.dstack([(u - CENTRE[0]) / FOCAL, (v - CENTRE[1]) / FOCAL, np.ones_like(u)])


def _object() -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]:
    """120 cameras, 3 degrees apart, 0.8 to 1 m away."""
    turn = 2 * np.pi * np.arange(120) / 120
    distance = 0.9 + 0.1 * np.sin(2 * turn)
    out = np.sqrt(distance**2 - 0.3**2)
    eyes = np.stack([out * np.cos(turn), out * np.sin(turn), np.full(120, 0.3)], axis=1)
    poses = [looking(eye, np.zeros(3)) for eye in eyes]
    tube = knot.Knot()
    return [tube.depth(T, _rays(), FOCAL, CENTRE) for T in poses], poses


def _room() -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]:
    """100 cameras on an arc of 198 degrees, held by hand."""
    poses = []
    for k in range(100):
        a = 1.1 * np.pi * k / 99
        eye = np.array([2 + 1.1 * np.cos(a), 2 + 1.1 * np.sin(a), 1.45])
        eye += [0.02 * np.sin(0.7 * k), 0.02 * np.cos(0.9 * k), 0.08 * np.sin(0.23 * k)]
        b = a + np.pi + 0.10 * np.sin(0.15 * k)
        ahead = np.array([np.cos(b), np.sin(b), -0.32 + 0.08 * np.sin(0.19 * k)])
        poses.append(looking(eye, eye + ahead, np.array([0.03 * np.sin(0.31 * k), 0.02 * np.cos(0.27 * k), 1.0])))
    return [room.depth(T, _rays()) for T in poses], poses


def looking(eye: NDArray, at: NDArray, up: NDArray | None = None) -> NDArray[np.float64]:
    """T_world_camera (4, 4) of a camera at `eye` that looks at `at`."""
    z = (at - eye) / np.linalg.norm(at - eye)
    x = np.cross(z, np.array([0, 0, 1.0]) if up is None else up)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), eye
    return T
