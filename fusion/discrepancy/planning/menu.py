"""The menu: recordings that a person with a wall, a board, some paper and an hour can make."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fusion.geometry.pose import Array
from fusion.simulation.scene.course import looking_at
from fusion.simulation.scene.scene import Scene
from fusion.simulation.scenes.panel import before, corner, near_card, slab, step, upright, wall
from fusion.simulation.scenes.patches import patches

COLD_S, WARM_S = 30.0, 6000.0  # a few seconds after switching on, and long after all is warm
COLD_C, WARM_C = 24.0, 38.0  # guess: of a closed camera of 5 to 15 W
GREYS = (0.05, 0.25, 0.8)
ROOM_WALL = (-2.0, 2.0), (-1.2, 1.2)  # [m] guess: to both sides, down and up, of a room's wall from its middle


@dataclass(frozen=True)
class Setup:
    """One thing to look at, from one pose."""

    scene: Scene  # what stands there
    pose: Array  # (4, 4) of the camera in the scene's world
    place: int  # recordings with the same number share the error of their poses: nothing was moved between them
    time: float = WARM_S  # since the sensor was switched on [s]
    celsius: float = WARM_C  # of the sensor
    light: float = 1.0  # share of the usual light of the lamp or exposure


@dataclass(frozen=True)
class Choice:
    """One recording of the menu."""

    name: str  # one word
    text: str  # what to do, as a sentence without a full stop
    minutes: float  # of work: guess
    switch: bool  # one thing is changed and nothing moved, so that the pose cancels
    setups: Callable[[], list[Setup]]  # what is seen; made only when asked for


@cache
def _room() -> Scene:
    """A wall as people have it: from far away or at an angle it does not fill the image."""
    return replace(wall(), parts=(upright(*ROOM_WALL, 0.0, 0.8),))


def _walls(distances: tuple[float, ...], tilts: tuple[float, ...] = (0.0,), together: bool = False) -> list[Setup]:
    poses = [before(d, t) for d in distances for t in tilts]
    scene = _room()
    return [Setup(scene, pose, 0 if together else k) for k, pose in enumerate(poses)]


def _warming_rail() -> list[Setup]:
    """The same walls soon after switching on, while it warms up, and warm."""
    distances = (0.5, 1.0, 2.0, 3.0, 4.0)
    cold = [
        replace(s, time=COLD_S + 30.0 * k, celsius=COLD_C + 0.5 * k)
        for k, s in enumerate(_walls(distances, together=True))
    ]
    return [*cold, *_walls(distances, together=True)]


@cache
def _papers() -> Scene:
    return patches(reflectance=GREYS, patch_m=0.3, columns=10, rows=8)


@cache
def _board() -> Scene:
    return step(step_m=0.5)


def _patches() -> list[Setup]:
    return [Setup(_papers(), before(d, t), k) for k, (d, t) in enumerate(((0.8, 0.0), (1.5, 30.0), (2.5, 0.0)))]


def _step() -> list[Setup]:
    return [Setup(_board(), before(d + 0.5), k) for k, d in enumerate((0.6, 1.0, 1.6, 2.4))]


def _rolled() -> list[Setup]:
    eye = np.array([1.2, 0.0, 0.0])
    scene = _room()
    return [Setup(scene, looking_at(eye, np.zeros(3), roll), k) for k, roll in enumerate((0.0, np.pi / 2))]


def _warming() -> list[Setup]:
    moments = ((COLD_S, COLD_C), (200.0, 27.0), (900.0, 33.0), (WARM_S, WARM_C))
    return [Setup(_board(), before(1.5), 0, time, celsius) for time, celsius in moments]


def _card() -> list[Setup]:
    return [Setup(near_card(card=card), before(2.0), 0) for card in (False, True)]


def _covered() -> list[Setup]:
    return [Setup(slab(covered=covered), before(0.8), 0) for covered in (False, True)]


def _dimmed() -> list[Setup]:
    return [Setup(_papers(), before(1.2), 0, light=light) for light in (1.0, 0.2)]


def _cloth() -> list[Setup]:
    pose = looking_at(np.array([1.5, 0.0, 0.0]), np.zeros(3))
    return [Setup(corner(black=black), pose, 0) for black in (False, True)]


MENU = (
    Choice(
        "time", "warm-up switch: one recording from cold to warm of a board before a wall, nothing moved, with frames "
        "half a minute after switching on, after 3, after 15 and after 100 minutes",
        100.0, True, _warming,
    ),
    Choice(
        "light", "amplitude switch: the same patches of black, grey and white paper twice from the same place, with "
        "the usual exposure or lamp and with a fifth of it", 10.0, True, _dimmed,
    ),
    Choice(
        "card", "near card switch: a wall at 2 m, with and without a white card close to the camera", 5.0, True, _card
    ),
    Choice(
        "slab", "material switch: a slab of soap, wax or marble against a wall of paper, bare and with a sheet of "
        "paper over it, and marked as translucent in its mesh", 10.0, True, _covered,
    ),
    Choice(
        "cloth", "corner switch: two walls that meet, with the second one bare and covered with black cloth",
        10.0, True, _cloth,
    ),
    Choice(
        "patches", "patches: a wall with patches of black, grey and white paper, from 0.8, 1.5 and 2.5 m",
        15.0, False, _patches,
    ),
    Choice(
        "step", "step target: a board half a metre before a wall, both in the picture, from 0.6 to 2.4 m",
        15.0, False, _step,
    ),
    Choice(
        "rail", "rail: a flat wall from distances known against each other, 0.5 to 4 m on a rail or by laser",
        20.0, False, lambda: _walls((0.5, 1.0, 2.0, 3.0, 4.0), together=True),
    ),
    Choice(
        "warm rail", "warm-up rail: a flat wall from distances known against each other, 0.5 to 4 m on a rail or by "
        "laser, within 3 minutes of switching on and again after 100 minutes", 100.0, False, _warming_rail,
    ),
    Choice(
        "distance", "distances: a flat wall from 0.5, 1, 2 and 4 m, set up anew each time",
        15.0, False, lambda: _walls((0.5, 1.0, 2.0, 4.0)),
    ),
    Choice(
        "tilt", "tilted wall: a flat wall at 45 degrees to both sides, from 1 and 2 m",
        10.0, False, lambda: _walls((1.0, 2.0), (-45.0, 45.0)),
    ),
    Choice(
        "roll", "rolled camera: the same wall from 1.2 m, the camera upright and turned by 90 degrees about its axis",
        10.0, False, _rolled,
    ),
)  # fmt: skip

QUICKEST = tuple(sorted(MENU, key=lambda choice: (not choice.switch, choice.minutes)))  # where one is enough
