"""A turntable: what it says, and how it really turns."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.decks import SIGMA_M, SIGMA_RAD
from tools.trial.concealed.rays import Camera, Panel, looking, nudged
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]
Rng = np.random.Generator

BANDS = 24  # of rows that are exposed together
STOPS, GOING = 8, 12
TOP = 0.6  # half the side of the plate [m]


@dataclass(frozen=True)
class Turn:
    """What the table and the clock do that nobody states.

    Attributes:
        offset, phase: of the true axis from the stated one [m], [rad from the direction of the camera].
        harmonics: (amplitude [rad], phase [rad]) of the angle's error, once, twice, ... a turn.
        late: the picture is that much younger than its time stamp [s].
        line: from one row to the next [s].
    """

    offset: float = 0.0
    phase: float = 0.0
    harmonics: tuple[tuple[float, float], ...] = ()
    late: float = 0.0
    line: float = 0.0

    def object_in_world(self, angle: float, to_camera: float) -> Array:
        """(4, 4) where the object frame stands at a commanded angle [rad]; `to_camera`: direction of the camera."""
        more = sum(a * np.sin((k + 1) * angle + p) for k, (a, p) in enumerate(self.harmonics))
        c, s = np.cos(angle + more), np.sin(angle + more)
        T = np.eye(4)
        T[:2, :2] = [[c, -s], [s, c]]
        E = self.offset * np.array([np.cos(self.phase + to_camera), np.sin(self.phase + to_camera)])
        T[:2, 3] = E - T[:2, :2] @ E
        return T


@dataclass(frozen=True)
class Run:
    """One recording of the table: what stands on it, the camera, commanded angles [deg] and rate [deg/s]."""

    panels: list[Panel]
    stated: Array
    error: Array
    start: float
    angles: Array
    rate: float


def runs_of(rng: Rng) -> list[Run]:
    """Step by step, forth, back, and step by step with the things placed anew."""
    eye = np.array([rng.uniform(0.75, 0.95), rng.uniform(-0.2, 0.2), rng.uniform(0.4, 0.55)])
    stated = looking(eye, np.array([0.0, 0.0, 0.14]), rng.uniform(-0.1, 0.1))
    first, second = _things(rng), _things(rng)
    out, start = [], rng.uniform(300, 600)
    for panels, angles, rate in (
        (first, 360.0 / STOPS * np.arange(STOPS), 0.0),
        (first, rng.uniform(0, 360) + np.arange(GOING) * 11.0, rng.uniform(15, 25)),
        (first, rng.uniform(0, 360) - np.arange(GOING) * 13.0, -rng.uniform(28, 42)),
        (second, 360.0 / STOPS * np.arange(STOPS), 0.0),
    ):
        error = rng.standard_normal(6) * np.array([SIGMA_RAD] * 3 + [SIGMA_M] * 3)
        out.append(Run(panels, stated, error, start, np.asarray(angles, float), rate))
        start += rng.uniform(60, 120)
    return out


def table_shots(camera: Camera, runs: list[Run], turn: Turn) -> list[list[Shot]]:
    """One shot per angle; where the table stands still, two frames of each."""
    out = []
    for number, run in enumerate(runs):
        shots = []
        for k, degrees in enumerate(run.angles):
            pause = 2.0 if not run.rate else abs(float(run.angles[1] - run.angles[0]) / run.rate)
            times = run.start + k * pause + (np.arange(2) / 30.0 if not run.rate else np.zeros(1))
            temperatures = np.full(len(times), 30.0)
            shot = Shot(camera, run.panels, np.eye(4), np.eye(4), times, temperatures)
            shots.append(replace(shot, degrees=float(degrees), series=number))
        out.append([_placed(shot, run, turn) for shot in shots])
    return out


def _placed(shot: Shot, run: Run, turn: Turn) -> Shot:
    to_camera = float(np.arctan2(run.stated[1, 3], run.stated[0, 3]))
    degrees = shot.degrees or 0.0

    def pose(seconds: float, how: Turn, camera: Array) -> Array:
        angle = np.deg2rad(degrees + run.rate * seconds)
        return np.asarray(np.linalg.solve(how.object_in_world(float(angle), to_camera), camera), float)

    really = nudged(run.stated, run.error)
    bands: tuple[Array, ...] = ()
    if turn.line and run.rate:
        middle = (np.arange(BANDS) + 0.5) / BANDS * shot.camera.height - shot.camera.height / 2
        bands = tuple(pose(turn.late + turn.line * row, turn, really) for row in middle)
    return replace(shot, T=pose(turn.late, turn, really), stated=pose(0.0, Turn(), run.stated), bands=bands)


def _things(rng: Rng) -> list[Panel]:
    """A plate, a chest and a box on it, each with five faces; world and plate frame are one at angle 0."""
    panels = [Panel(np.array([-TOP, -TOP, 0.0]), np.array([2 * TOP, 0, 0]), np.array([0, 2 * TOP, 0]), _grey(0.5))]
    away = rng.uniform(0, 2 * np.pi)
    for size, radius, turn in (((0.34, 0.24, 0.32), 0.1, 0.0), ((0.2, 0.2, 0.2), 0.3, np.pi)):
        at = radius * np.array([np.cos(away + turn), np.sin(away + turn)])
        panels += _box(np.array(size) * rng.uniform(0.9, 1.1, 3), at, rng.uniform(0, np.pi))
    return panels


def _box(size: Array, at: Array, turned: float) -> list[Panel]:
    c, s = np.cos(turned), np.sin(turned)
    x, y, z = np.array([c, s, 0]) * size[0], np.array([-s, c, 0]) * size[1], np.array([0, 0, size[2]])
    low = np.array([*at, 0.0]) - x / 2 - y / 2
    sides = [(low, x, z), (low + x, y, z), (low + x + y, -x, z), (low + y, -y, z), (low + z, x, y)]
    return [Panel(corner, a, b, _grey(0.8)) for corner, a, b in sides]


def _grey(value: float) -> Array:
    return np.array([[value]])
