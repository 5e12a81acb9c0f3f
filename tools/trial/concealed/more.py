"""More recordings by the camera of a case: of the same kind, beyond it, and of the kinds that an answer may ask for."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.decks import FRAMES, LONG, RATE, SIZE, USUAL, Setting, Span, degrees_at, scene_of
from tools.trial.concealed.rays import looking, nudged
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]
Rng = np.random.Generator

# deck, distances and tilts of what may be asked for, where its text leaves them open
ASKED = {
    "distance": ("plain walls", Span(0.5, 4.0, 0.0, 10.0)),
    "rail": ("plain walls", Span(0.5, 4.0, 0.0, 4.0)),
    "warm rail": ("plain walls", Span(0.5, 4.0, 0.0, 4.0)),
    "patches": ("patches", Span(0.8, 2.5, 0.0, 20.0)),
    "light": ("patches", Span(0.8, 2.0, 0.0, 20.0)),
    "step": ("step", Span(0.9, 2.4, 0.0, 20.0)),
    "tilt": ("plain walls", Span(1.0, 2.0, 40.0, 50.0)),
    "roll": ("plain walls", Span(1.2, 1.3, 20.0, 40.0)),
    "card": ("card", Span(1.8, 2.2, 0.0, 20.0)),
    "cloth": ("corner", Span(1.0, 2.0, 0.0, 20.0)),
}
# distance [m] and tilt to the side [deg] of what is asked for by its numbers
PLACES = {
    "distance": ((0.5, 0.0), (1.0, 0.0), (2.0, 0.0), (4.0, 0.0)),
    "rail": ((0.5, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)),
    "warm rail": ((0.5, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)),
    "tilt": ((1.0, -45.0), (1.0, 45.0), (2.0, -45.0), (2.0, 45.0)),
    "patches": ((0.8, 0.0), (1.5, 30.0), (2.5, 0.0)),
    "light": ((1.2, 0.0),),
}
BY_HAND = 0.05, 3.0  # of a distance, [deg]: so well a person sets up what a text says
WARMING_S = (30.0, 200.0, 900.0, 6000.0)  # since switching on
COLD_AND_WARM_S = (30.0, 6000.0)
DIM, RAIL = 0.2, 0.2  # of the usual light, of the usual error of a pose


def more_shots(rng: Rng, setting: Setting, before: list[Shot], how: Span, count: int = 2) -> list[Shot]:
    """Recordings of the same kind, at other distances or tilts, made by the same camera."""
    shots: list[Shot] = []
    ends = before[-1].times[-1]
    for i in range(count):
        start = rng.uniform(60.0, 3300.0) if setting.kind in LONG and how is USUAL else ends + 400.0 * (i + 1)
        times = start + np.arange(FRAMES) / RATE
        panels, stated = scene_of(rng, setting, i, shots, {"white": None, "patches": None}, how)
        T = nudged(stated, setting.poses * SIZE * rng.standard_normal(6))
        shots.append(Shot(before[0].camera, panels, T, stated, times, degrees_at(rng, times), sigma=setting.stated))
    return shots


def asked_shots(rng: Rng, kind: str, before: list[Shot], count: int = 4) -> list[Shot]:
    """Recordings of one of the kinds in `ASKED`, or of one scene cold and warm ("time"), by the same camera."""
    if kind == "time":
        return _cold_and_warm(rng, before)
    deck, span = ASKED[kind]
    places = PLACES.get(kind, ())
    shots = more_shots(rng, Setting(deck, False), before, span, len(places) or count)
    shots = [_placed(rng, shot, *place) for shot, place in zip(shots, places, strict=True)] if places else shots
    if kind == "light":  # the same place again, with less of it
        twins = [replace(shot, lamp=DIM, kept={}, times=shot.times + 10.0) for shot in shots]
        return [shot for pair in zip(shots, twins, strict=True) for shot in pair]
    if kind in ("rail", "warm rail"):
        shots = [
            replace(shot, T=nudged(shot.stated, RAIL * SIZE * rng.standard_normal(6)), sigma=RAIL) for shot in shots
        ]
    if kind == "warm rail":
        return [_at(rng, shot, start + 30.0 * k) for start in COLD_AND_WARM_S for k, shot in enumerate(shots)]
    return [_rolled(rng, shot) if kind == "roll" and k % 2 else shot for k, shot in enumerate(shots)]


def _at(rng: Rng, shot: Shot, start: float) -> Shot:
    times = start + np.arange(FRAMES) / RATE
    return replace(shot, times=times, temperatures=degrees_at(rng, times), kept={})


def _placed(rng: Rng, shot: Shot, distance: float, tilt_deg: float) -> Shot:
    """The shot from where the text says, about the middle of the wall."""
    away = distance * (1 + BY_HAND[0] * rng.standard_normal())
    tilt = np.deg2rad(tilt_deg + BY_HAND[1] * rng.standard_normal())
    target = np.array([rng.uniform(-0.2, 0.2), 0.0, rng.uniform(-0.2, 0.2)])
    stated = looking(target + away * np.array([np.sin(tilt), -np.cos(tilt), 0.0]), target, rng.uniform(-0.1, 0.1))
    return replace(shot, stated=stated, T=nudged(stated, SIZE * rng.standard_normal(6)), kept={})


def _cold_and_warm(rng: Rng, before: list[Shot]) -> list[Shot]:
    """One recording of a board before a wall, in which nothing moves."""
    first = more_shots(rng, Setting("step", False), before, Span(1.8, 2.2, 0.0, 20.0), 1)[0]
    times = [start + np.arange(FRAMES) / RATE for start in WARMING_S]
    return [replace(first, times=own, temperatures=degrees_at(rng, own), series=0, kept={}) for own in times]


def _rolled(rng: Rng, shot: Shot) -> Shot:
    """The camera turned by 90 degrees about its axis."""
    quarter = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    stated = shot.stated @ quarter
    return replace(shot, stated=stated, T=nudged(stated, SIZE * rng.standard_normal(6)))
