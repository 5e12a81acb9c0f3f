"""Scenes by name; each is data made by a small function whose arguments are its settings."""

from collections.abc import Callable, Mapping
from inspect import Parameter, getdoc, signature
from typing import Any

import numpy as np

from fusion.errors import FusionError, SceneError
from fusion.simulation.scene.scene import Scene
from fusion.simulation.scenes.boards import charuco, checkerboard
from fusion.simulation.scenes.panel import approach, corner, near_card, slab, step, wall, warm_up
from fusion.simulation.scenes.patches import patches
from fusion.simulation.scenes.room import room
from fusion.simulation.scenes.target import target
from fusion.simulation.scenes.turntable import turntable

SCENES: dict[str, Callable[..., Scene]] = {
    "wall": wall,
    "approach": approach,
    "target": target,
    "step": step,
    "corner": corner,
    "patches": patches,
    "checkerboard": checkerboard,
    "charuco": charuco,
    "near-card": near_card,
    "slab": slab,
    "warm-up": warm_up,
    "turntable": turntable,
    "room": room,
}
YES, NO = ("yes", "true", "on", "1"), ("no", "false", "off", "0")


def built_in(name: str, settings: Mapping[str, Any] | None = None) -> Scene:
    """The scene of that name; `settings` as values, or as text with commas in lists. Raises SceneError.

    >>> len(fusion.built_in("wall", {"distance_m": (0.8, 1.2, 1.6), "frames": 5}).course)
    15
    """
    if name not in SCENES:
        expected = "a scene file, a recording's folder or one of " + ", ".join(SCENES)
        raise SceneError("no such scene", found=name, expected=expected, do="see fusion simulate --list")
    known = settings_of(name)
    values = {}
    for key, text in (settings or {}).items():
        if key not in known:
            raise SceneError(f"the scene {name} has no such setting", "--set", key, "one of " + ", ".join(known))
        values[key] = _value(f"{name}: {key}", text, known[key])
    try:
        return SCENES[name](**values)
    except FusionError as error:
        if not settings:
            raise
        given = ", ".join(f"{key}={str(value)[:40]}" for key, value in settings.items())
        raise SceneError(error.what, f"{name} with {given}", error.found, error.expected, error.do) from error


def settings_of(name: str) -> dict[str, object]:
    """The settings of a scene and their usual values."""
    found = signature(SCENES[name]).parameters.values()
    return {entry.name: entry.default for entry in found if entry.default is not Parameter.empty}


def about(name: str) -> str:
    """One line about a scene."""
    return (getdoc(SCENES[name]) or "").splitlines()[0]


def _value(where: str, given: Any, usual: Any) -> Any:
    text = given if isinstance(given, str) else ",".join(map(str, np.ravel(given)))
    try:
        if isinstance(usual, bool):
            if text.lower() not in YES + NO:
                raise ValueError(text)
            return text.lower() in YES
        if isinstance(usual, tuple):
            return tuple(_finite(part) for part in text.split(","))
        return _finite(text) if isinstance(usual, float) else type(usual)(text)
    except ValueError as error:
        kinds = {bool: "yes or no", int: "a whole number", float: "a finite number", tuple: "finite numbers, commas"}
        raise SceneError("a setting cannot be read", where, text, kinds[type(usual)]) from error


def _finite(text: str) -> float:
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(text)
    return value
