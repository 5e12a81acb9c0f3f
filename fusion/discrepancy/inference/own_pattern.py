"""Own pattern: what is frozen into every unit in its own way, of which a model knows the usual size alone.

How alike two places of the image are is drawn from many units, at the size of tiles; a unit that differs from all
others by its own pattern lacks nothing.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

UNITS = 400  # that are drawn: correlations are good to a twentieth
SMOOTH = 0.03  # of its size: what changes less from a column to the next is a field, and no pattern of pixels


def own_patterns(observations: Observations) -> Matrix:
    """(n, n) covariance in native units of the patterns that this unit may have; the same in all recordings."""
    total = np.zeros((len(observations.residual),) * 2)
    for effect in unknown_patterns(observations.sensor):
        size = np.concatenate([_size(patch, effect) for patch in observations.patches])
        if np.any(size):
            cells, first = _cells(observations), observations.patches[0]
            drawn = _drawn(effect, first.view.camera, first.view.baseline, first.view.principle, first.tiles.side)
            own, place = np.unique(cells, return_inverse=True)
            alike = drawn[:, own].T @ drawn[:, own] / UNITS
            total += alike[np.ix_(place, place)] * np.outer(size, size)
    return total


def unknown_patterns(sensor: Sensor) -> Iterator[Effect]:
    """Effects that every unit has in its own way, and of which the model holds a size."""
    for effect in sensor.effects:
        if effect.frozen == "unit":
            yield effect


def _cells(observations: Observations) -> NDArray[np.intp]:
    """(n,) number of each tile's place in the grid of the first patch."""
    side = observations.patches[0].tiles.side
    across = -(-observations.patches[0].view.camera.width // side)
    places = [patch.tiles.cell * patch.tiles.side // side for patch in observations.patches]
    row, column = np.concatenate(places).T
    return np.asarray(row * across + column)


def _size(patch: Patch, effect: Effect) -> Vector:
    """(n,) spread of a pixel over all units, in native units with their sign."""
    with np.errstate(all="ignore"):
        return patch.tiles.mean(effect.noise(patch.depth, patch.view) * patch.native)


@lru_cache(maxsize=16)  # recordings have one camera; a menu's cut it into squares of some ten sizes
def _drawn(effect: Effect, camera: Camera, baseline: float, principle: Principle, side: int) -> Matrix:
    """(UNITS, cells) means over squares of the image in units of one model, where pixels have a spread of one."""
    wall, sides = _wall(camera, baseline, principle), (side, side)
    height, width = (-(-size // side) for size in camera.shape)
    one = _pattern(effect, wall, 0)
    if not np.ptp(one, axis=0).any():  # of whole columns: one row tells them
        wall, sides = _wall(camera.resized(camera.width, height), baseline, principle), (1, side)
    elif _is_smooth(one):  # a square is as well told by four places in it
        wall, sides = _wall(camera.resized(2 * width, 2 * height), baseline, principle), (2, 2)
    return np.array([_means(_pattern(effect, wall, unit), sides) for unit in range(UNITS)])


def _is_smooth(image: Image) -> bool:
    return bool(np.diff(image, axis=1).std() < SMOOTH * image.std())


def _means(image: Image, sides: tuple[int, int]) -> Vector:
    """(cells,) means over rectangles of so many rows and columns; those at the right and lower rim may be smaller."""
    rows, columns = (np.arange(0, size, side) for size, side in zip(image.shape, sides, strict=True))
    sums = np.add.reduceat(np.add.reduceat(image, rows, axis=0), columns, axis=1)
    return np.asarray(sums / np.outer(_lengths(rows, image.shape[0]), _lengths(columns, image.shape[1]))).ravel()


def _lengths(starts: NDArray[np.intp], size: int) -> NDArray[np.intp]:
    return np.diff(np.append(starts, size))


def _pattern(effect: Effect, wall: View, unit: int) -> Image:
    """(h, w) error of the pixels of one unit over its spread."""
    assert wall.depth is not None
    seen = replace(wall, moment=replace(wall.moment, unit=unit))
    with np.errstate(all="ignore"):
        ratio = effect.bias(wall.depth, seen) / effect.noise(wall.depth, seen)
    return np.nan_to_num(np.broadcast_to(ratio, wall.camera.shape), posinf=0.0, neginf=0.0)


def _wall(camera: Camera, baseline: float, principle: Principle) -> View:
    """A wall at a metre."""
    nowhere = np.zeros(camera.shape)
    return View(camera, nowhere + 1.0, nowhere, baseline=baseline, principle=principle)
