"""Decks: ten scenes and camera positions, the kinds of recordings that people make to check a depth camera."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.rays import Bow, Camera, Panel, looking, nudged
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]
Rng = np.random.Generator

FRAMES, RATE = 7, 30.0
SIGMA_M, SIGMA_RAD = 0.0005, 0.0005
SIZE = np.array([SIGMA_RAD] * 3 + [SIGMA_M] * 3)
LONG = ("warm",)
GREYS = np.array([15, 64, 204]) / 255.0
NEAREST = 0.4  # [m] before the camera: nearer, no such sensor gives a depth
CARD = 217 / 255.0


@dataclass(frozen=True)
class Setting:
    """How a deck is drawn.

    Attributes:
        kind: "walls", "patches", "card", "corner", "warm", "ordered" (near to far, white, frontal), "plain
            walls" (nothing but white walls), "trend" (the
            farther, the later, though not in every recording), "sides" (dark things mostly on one side).
        flight: for a time-of-flight camera.
        bow_m: how far walls are from flat.
        worst_pose: one recording whose pose is off by this many standard deviations.
        poses: how many times larger than usual errors of all poses are.
        stated: how many times larger they are said to be.
    """

    kind: str
    flight: bool
    bow_m: float = 0.0
    worst_pose: float = 0.0
    poses: float = 1.0
    stated: float = 1.0


@dataclass(frozen=True)
class Span:
    """Distances [m] and tilts [deg] from which recordings are drawn."""

    near: float = 0.6
    far: float = 3.2
    least_deg: float = 0.0
    most_deg: float = 45.0


USUAL, BEYOND = Span(), Span(3.4, 4.0, 0.0, 55.0)


def camera_of(rng: Rng, flight: bool) -> Camera:
    width, height, f = (176, 144, 126.0) if flight else (208, 160, 185.0)
    f *= rng.uniform(0.99, 1.01)
    return Camera(width, height, f, (width - 1) / 2 + rng.uniform(-2, 2), (height - 1) / 2 + rng.uniform(-2, 2))


def shots_of(rng: Rng, setting: Setting) -> list[Shot]:
    """All recordings of a case, in the order in which they are made."""
    camera = camera_of(rng, setting.flight)
    long = setting.kind in LONG
    starts = np.cumsum(np.concatenate([[rng.uniform(40, 70)], rng.uniform(120, 280, 9)]))
    if long:
        starts = np.concatenate([[60.0], 60.0 + 540.0 * rng.permutation(7)])
    bows = _bows(rng, setting.bow_m)
    worst = int(rng.integers(len(starts)))
    shots: list[Shot] = []
    for i, start in enumerate(starts):
        times = start + (np.arange(20) * 150.0 if long and i == 0 else np.arange(FRAMES) / RATE)
        panels, stated = scene_of(rng, setting, i, shots, bows)
        size = setting.poses * SIZE
        error = rng.standard_normal(6)
        if setting.worst_pose and i == worst:
            error *= setting.worst_pose / np.linalg.norm(error) * np.sqrt(6)
        T = nudged(stated, error * size)
        shots.append(
            Shot(camera, panels, T, stated, times, degrees_at(rng, times), long and i == 0, sigma=setting.stated)
        )
    return shots


def degrees_at(rng: Rng, times: Array) -> Array:
    """Temperature [degC] as logged."""
    return np.asarray(24.0 + 16.0 * (1 - np.exp(-times / 900.0)) + 0.02 * rng.standard_normal(len(times)))


def scene_of(
    rng: Rng, setting: Setting, i: int, before: list[Shot], bows: dict[str, Bow | None], how: Span = USUAL
) -> tuple[list[Panel], Array]:
    kind = setting.kind
    if kind == "card" and i % 2:  # the same again, with something near
        return [*before[-1].panels, _near(rng, before[-1].stated)], nudged(
            before[-1].stated, 1e-3 * rng.standard_normal(6)
        )
    white = kind in ("ordered", "plain walls", "trend", "warm", "step") or (
        kind in ("walls", "card") and rng.random() < 0.6
    )
    wall = _wall("white" if white else "patches", bows)
    panels = [wall]
    if kind == "sides":
        panels = [_sides(rng)]
    if (kind in ("walls", "warm") and i in (2, 7)) or kind == "step":
        panels = [_wall("white", bows), _step(rng)]
    if kind == "corner":
        panels = [
            wall,
            Panel(np.array([1.0, 0.0, 1.2]), np.array([0, -1.6, 0.0]), np.array([0, 0, -2.4]), np.array([[0.8]])),
        ]
    distance = rng.uniform(how.near, how.far)
    if kind in ("ordered", "trend") and how is USUAL:
        distance = (
            0.65 + 0.3 * i if kind == "ordered" else float(np.clip(0.65 + 0.27 * i + 0.3 * rng.normal(), 0.6, 3.2))
        )
    frontal = kind == "ordered" or (not how.least_deg and rng.random() < 0.25)
    tilts = (0.0, 4.0) if frontal else (how.least_deg, how.most_deg)
    stated = _pose(rng, distance, tilts, kind == "corner")
    for panel in panels[1:] if kind != "corner" else []:  # a board, which a camera near the wall would stand in
        panel.corner[1] = max(panel.corner[1], stated[1, 3] + NEAREST)
    return panels, stated


def _pose(rng: Rng, distance: float, tilts_deg: tuple[float, float], corner: bool) -> Array:
    target = np.array([rng.uniform(0.3, 0.9) if corner else rng.uniform(-0.3, 0.3), 0.0, rng.uniform(-0.25, 0.25)])
    tilt, turn = np.deg2rad(rng.uniform(*tilts_deg)), rng.uniform(0, 2 * np.pi)
    if corner:
        distance, turn, tilt = min(distance, 2.2), np.pi + rng.uniform(-0.5, 0.5), min(tilt, 0.6)
    away = np.array([np.sin(tilt) * np.cos(turn), -np.cos(tilt), np.sin(tilt) * np.sin(turn)])
    return looking(target + distance * away, target, rng.uniform(-0.15, 0.15))


def _wall(look: str, bows: dict[str, Bow | None]) -> Panel:
    cells = np.array([[0.8]])
    if look == "patches":
        row, column = np.mgrid[0:6, 0:8]
        cells = GREYS[(row + 2 * column) % 3]
    return Panel(np.array([-1.6, 0, 1.2]), np.array([3.2, 0, 0]), np.array([0, 0, -2.4]), cells, bows[look])


def _sides(rng: Rng) -> Panel:
    """Patches that are mostly bright on the left and mostly dark on the right."""
    bright = rng.random((6, 10)) < np.where(np.arange(10) < 5, 0.8, 0.2)
    return Panel(
        np.array([-1.6, 0, 1.2]), np.array([3.2, 0, 0]), np.array([0, 0, -2.4]), np.where(bright, 0.8, GREYS[0])
    )


def _step(rng: Rng) -> Panel:
    """A board before one half of the wall."""
    return Panel(
        np.array([0.0, -rng.uniform(0.35, 0.6), 0.9]), np.array([1.3, 0, 0]), np.array([0, 0, -1.8]), np.array([[0.8]])
    )


def _near(rng: Rng, stated: Array) -> Panel:
    """A white card close to the camera, to one side."""
    z = rng.uniform(0.35, 0.5)
    corner = stated @ np.array([0.18 * z / 0.5, -0.2, z, 1])
    return Panel(corner[:3], stated[:3, 0] * 0.3, stated[:3, 1] * 0.4, np.array([[CARD]]))


def _bows(rng: Rng, size: float) -> dict[str, Bow | None]:
    out: dict[str, Bow | None] = {"white": None, "patches": None}
    if size:
        for look in out:
            # half a wave and more along the wall: a bow, not a wall that stands elsewhere
            along, up = rng.uniform(0.5, 1.5, 4), rng.uniform(-1.0, 1.0, 4)
            waves = np.column_stack([along, up, rng.uniform(0, 6, 4)])
            heights = rng.standard_normal(4)
            out[look] = Bow(heights * size / np.sqrt((heights**2).sum() / 2), waves)
    return out
