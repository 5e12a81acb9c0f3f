"""A furnished room, seen by a camera in a moving hand."""

import numpy as np

from fusion.mesh.mesh import Mesh
from fusion.simulation.scene.course import SimulatedCourse, looking_at, stamps
from fusion.simulation.scene.scene import Part, Scene, StatedPoses
from fusion.simulation.scene.shapes import Points, box, sheet
from fusion.simulation.scenes.panel import WARM_S

WIDE, DEEP, HIGH = 4.2, 3.4, 2.5  # [m]
SHAKE_M, SHAKE_RAD = 0.002, 0.004  # guess: of a hand, at 5 to 8 Hz


def room(frames: int = 90, sweep_deg: float = 70.0, sigma_m: float = 0.003, sigma_rad: float = 0.003) -> Scene:
    """a room with furniture, a hand-held camera that sweeps through it at 30 frames a second"""
    times = stamps(frames, 1 / 30, WARM_S)
    return Scene(
        name="room",
        parts=tuple(Part(mesh) for mesh in [*_walls(), *_furniture()]),
        course=SimulatedCourse(times, _hand(times - times[0], sweep_deg), continuous=True),
        poses=StatedPoses("tracked", sigma_m, sigma_rad),
        ambient_lux=300.0,
        color=True,
    )


def _hand(t: np.ndarray, sweep_deg: float) -> np.ndarray:
    """(n, 4, 4): there and back in six seconds, with the small shake of a hand."""
    phase = 2 * np.pi * t / 6.0
    sweep = np.deg2rad(sweep_deg) / 2 * np.sin(phase)
    shake = np.column_stack([np.sin(2 * np.pi * f * t + f) for f in (5.1, 6.3, 7.7)])
    eye = np.column_stack([0.9 + 0.25 * np.cos(phase), 0.35 * np.sin(phase), 1.35 + 0.1 * np.sin(2 * phase)])
    eye += SHAKE_M * shake
    aim = np.column_stack([-np.cos(sweep), np.sin(sweep), -0.25 + SHAKE_RAD * shake[:, 2]])
    return np.array([looking_at(e, e + a, SHAKE_RAD * s[0]) for e, a, s in zip(eye, aim, shake, strict=True)])


def _walls() -> list[Mesh]:
    x, y, z = np.eye(3)
    low = np.array([-WIDE / 2, -DEEP / 2, 0.0])
    high = -low + [0, 0, HIGH]
    floor = sheet(low, WIDE * x, DEEP * y, _boards)
    ceiling = sheet(high, -WIDE * x, -DEEP * y, lambda p: np.full((len(p), 3), 225.0))
    sides = [(low, DEEP * y), (low, WIDE * x), (high - HIGH * z, -DEEP * y), (high - HIGH * z, -WIDE * x)]
    return [floor, ceiling, *(sheet(corner, along, HIGH * z, _wallpaper) for corner, along in sides)]


def _furniture() -> list[Mesh]:
    return [
        box((-1.9, -1.5, 0.0), (-1.4, -0.3, 1.9), (140, 104, 72)),  # a cupboard
        box((-1.3, 0.35, 0.68), (-0.1, 1.1, 0.72), (176, 138, 98)),  # a table on four legs
        *(box((a, b, 0.0), (a + 0.05, b + 0.05, 0.68), (96, 76, 58)) for a in (-1.28, -0.17) for b in (0.37, 1.03)),
        box((-0.95, 0.55, 0.72), (-0.65, 0.8, 0.98), (62, 96, 128)),  # what lies on it
        box((-0.5, 0.7, 0.72), (-0.3, 0.85, 0.8), (170, 60, 54)),
        box((-0.45, -0.9, 0.0), (0.0, -0.45, 0.45), (86, 120, 84)),  # a stool
        box((-2.1, -0.1, 0.9), (-2.04, 0.7, 1.6), (60, 62, 70)),  # a picture
        box((-2.1, 0.9, 0.0), (-1.7, 1.6, 0.8), (196, 190, 178)),
    ]


def _boards(p: Points) -> Points:
    board = np.floor(p[:, 1] / 0.14)
    return np.array([150.0, 116.0, 84.0]) + 14.0 * np.sin(board * 2.7)[:, None]


def _wallpaper(p: Points) -> Points:
    stripe = np.floor((p[:, 0] + p[:, 1]) / 0.25) % 2
    return np.array([196.0, 190.0, 176.0]) + 12.0 * stripe[:, None]
