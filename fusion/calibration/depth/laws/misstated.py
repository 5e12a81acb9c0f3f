"""A wall whose stated distance cannot be: a typing error, or another wall than the one that was measured."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.information import evidence_of
from fusion.calibration.depth.laws.selection import JudgedLaw, on_axis, upright
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.geometry.robust import MAD_TO_STD
from fusion.sensor.sensor import Sensor

Array = NDArray[np.float64]
SUSPECTED = 5.0  # times farther off than walls usually are, or their distances: asked for the law without it (guess)
TIMES = 10.0  # the same by that law, which it does not spoil (guess)
FEWEST = 5  # walls of known distance: of fewer none is usual
MOST = 0.25  # share of the walls: more of them are no slips
ALIKE = 1.25  # factor of brightness that a law of the others knows as well (guess)
BETTER = 0.5  # of the others' error on walls left out, without it (guess)


def misstated(walls: Sequence[Wall], judged: Sequence[JudgedLaw], chosen: int, flight: bool) -> int | None:
    """The wall that is farthest from where it is said to stand, by more than usual: its index, or None.

    Laws were fitted without each wall once. A bad wall spoils what is said of the others by its share in the fit,
    however far off it is: whether it is wrong the law without it says (`stands_wrong`). A wall counts by the law in
    use, or where that is spoiled by the candidate that suits it best. Not asked is what a law of the others need not
    know: the nearest and the farthest wall and, of time of flight (`flight`), a plainly brighter or darker one than all
    others, or any without infrared images.
    """
    known = np.array([np.isfinite(wall.distance) and not wall.by_board for wall in walls])
    if known.sum() < FEWEST:
        return None
    inner = known & _between(np.array([wall.depth_there for wall in walls]), known)
    if flight:
        inner &= _between(np.array([_reflectance(wall) for wall in walls]), known, ALIKE)
    usual = np.array([wall.distance_std / MAD_TO_STD for wall in walls])
    for off in (np.abs(judged[chosen].offset), _least(judged)):
        worst = int(np.argmax(np.where(inner, off, 0.0)))
        others = np.delete(off, worst)[np.delete(known, worst)]
        if inner[worst] and off[worst] > SUSPECTED * max(float(np.median(others)), float(usual[worst])):
            return worst
    return None


def stands_wrong(wall: Wall, sensor: Sensor, camera: Camera, others: JudgedLaw) -> bool:
    """A wall that was left out stands elsewhere by what the others say, each of which was left out once, too."""
    usual = max(float(np.nanmedian(np.abs(others.offset))), wall.distance_std / MAD_TO_STD)
    return abs(_stands(wall, sensor, camera) - wall.distance) > TIMES * usual


def told(wall: Wall, sensor: Sensor, camera: Camera, others: int) -> str:
    """The sentence of a wall that was left out; the model is that of the others."""
    there = _stands(wall, sensor, camera)
    return (
        f"{wall.name} is left out: it is said to stand at {wall.distance:.3f} m, and does at {there:.3f} m by what the "
        f"other {others} walls agree on; check its distance_m (telemetry.csv)"
    )


def _stands(wall: Wall, sensor: Sensor, camera: Camera) -> float:
    """Where it stands by a model [m]."""
    depth = sensor.correct(wall.measured, wall.view(camera, wall.measured))
    seen = evidence_of(replace(wall, depth=depth), camera, sensor, [])
    return float(wall.distance + on_axis(seen, upright(seen, seen.rest)))


def _least(judged: Sequence[JudgedLaw]) -> Array:
    """(w,) how far each wall is off by the candidate that suits it best [m]."""
    return np.asarray(np.abs([law.offset for law in judged]).min(axis=0))


def _between(values: Array, known: NDArray[np.bool_], alike: float = 1.0) -> NDArray[np.bool_]:
    """Which values lie between those of the others, or within a factor of them."""
    others = [values[known & (np.arange(len(values)) != i)] for i in range(len(values))]
    pairs = zip(values, others, strict=True)
    return np.array([o.size > 0 and o.min() / alike < v < o.max() * alike for v, o in pairs])


def _reflectance(wall: Wall) -> float:
    """Brightness of the surface, in units of its own; NaN where no image tells it."""
    if wall.ir is None or not wall.mask.any():
        return float("nan")
    return float(np.median(wall.ir[wall.mask]) * float(np.nanmedian(wall.measured[wall.mask])) ** 2)
