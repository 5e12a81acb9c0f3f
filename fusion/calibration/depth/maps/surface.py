"""What is left per pixel: one smooth map for all distances, or a stack of maps read between the two nearest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

from fusion.calibration.depth.laws.information import WallEvidence
from fusion.calibration.depth.laws.selection import JudgedLaw, Problem, level, on_axis, upright
from fusion.calibration.depth.laws.terms import length, pixels
from fusion.calibration.depth.laws.variance import spread_of, with_variance
from fusion.calibration.depth.walls.tiles import TileGrid
from fusion.sensor.sensor import Sensor

SMOOTH = 1.0  # standard width of the smoothing [tiles]
TURNS = 3  # rounds of a map and the walls' own tilts and distances: ten and thirty move a scale by 0.02 % at most
LEAST_WALLS = 4  # with fewer, a stack is no more than the walls' own noise
Array = NDArray[np.floating]


@dataclass(frozen=True)
class MapStack:
    """Maps of the error in the sensor's own unit, pixels of disparity or metres along the ray, over a grid of tiles."""

    distance: Array  # (n,) of the walls [m], increasing
    maps: Array  # (n, rows, columns)
    # u, v: centres of the tiles [px]
    u: Array
    v: Array
    std: float = 0.0  # of a usual tile of a map, in the same unit
    # (w, rows, columns) independent errors of one map, by how each of w walls differs from it; none of a stack, whose
    # maps are of one wall each
    errors: tuple[Array, ...] = ()


def native(evidence: WallEvidence, sensor: Sensor) -> Array:
    """(t,) change of the depth [m] per unit of error in the sensor's own unit."""
    unit = pixels if sensor.principle.triangulates else length
    at = evidence.samples
    return at.tile_means(unit(lambda samples: np.ones(len(samples.depth)))(at))


def judge_surface(problem: Problem, base: JudgedLaw, units: list[Array], kind: str) -> JudgedLaw:
    """The base law with a map or stack of what it leaves over, each wall left out once."""
    distances = np.array([e.wall.true_plane.distance for e in problem.evidence])
    every = list(zip(problem.evidence, base.residual, units, strict=True))
    maps = _maps(every, kind)
    chi2, offset, rms, left = [], [], [], []
    for i, e in enumerate(problem.evidence):
        others = [n for n in range(len(maps)) if n != i]
        seen = _maps([every[n] for n in others], kind) if kind == "map" else [maps[n] for n in others]
        rest: Array = base.residual[i] - units[i] * _read(
            _expected(kind, seen, distances[others], float(distances[i])), e
        )
        chi2.append(float(rest @ e.projected(rest)))
        rest = upright(e, rest)
        offset.append(on_axis(e, rest))
        rms.append(float(np.sqrt(np.average(rest**2, weights=e.tiles.count))))
        left.append(rest)
    candidate = replace(base.candidate, name=f"{base.candidate.name} + {kind}", surface=kind)
    return JudgedLaw(candidate, base.law, np.array(chi2), np.array(offset), np.array(rms), tuple(left))


def stack_of(evidence: list[WallEvidence], units: list[Array], kind: str) -> MapStack:
    """The maps of what is left on each wall (`rest` of the evidence); one of all walls for the kind "map"."""
    order = np.argsort([e.wall.true_plane.distance for e in evidence])
    maps = _maps([(evidence[i], evidence[i].rest, units[i]) for i in order], kind)
    distances = np.array([evidence[i].wall.true_plane.distance for i in order])
    centres = _centres(evidence[0].tiles)
    if kind == "map":
        return MapStack(distances[:1], filled(_mean(maps)[0])[None], *centres, _std_of_mean(maps), _apart(maps))
    weight = np.concatenate([w[w > 0] for _, w in maps])
    std = 1 / np.sqrt(4 * np.pi * SMOOTH**2 * np.median(weight))  # a bell counts that many tiles
    return MapStack(distances, np.array([filled(values) for values, _ in maps]), *centres, float(std))


def _apart(maps: list[tuple[Array, Array]]) -> tuple[Array, ...]:
    """Shares of the walls in the mean map less its own there: with all walls' squares added, its covariance."""
    mean, total = _mean(maps)
    more = np.sqrt(len(maps) / max(len(maps) - 1, 1))
    return tuple(more * np.nan_to_num(value - mean) * weight / np.maximum(total, 1e-300) for value, weight in maps)


def _std_of_mean(maps: list[tuple[Array, Array]]) -> float:
    """Standard deviation of a usual tile of the mean map, by how much the walls differ from it."""
    mean, total = _mean(maps)
    squares = np.sum([(np.nan_to_num(value - mean) * weight) ** 2 for value, weight in maps], axis=0)
    seen = np.sum([weight > 0 for _, weight in maps], axis=0)
    often = seen > 1  # one wall alone does not differ from itself
    if not often.any():
        return 0.0
    return float(np.median(np.sqrt(squares[often] * seen[often] / (seen[often] - 1)) / total[often]))


def _centres(tiles: TileGrid) -> tuple[Array, Array]:
    """Columns and rows [px] of the middles of the tiles."""
    rows, columns = tiles.grid
    middle = (tiles.side - 1) / 2
    return middle + tiles.side * np.arange(columns), middle + tiles.side * np.arange(rows)


def _maps(walls: Sequence[tuple[WallEvidence, Array, Array]], kind: str) -> list[tuple[Array, Array]]:
    """Map and weight of each wall, its rest and unit; tilt and distance belong to the wall and not to the pixels.

    Of one map for all walls they are fitted beside it, in turns: a board sees a piece of the image only, and its tilt
    and distance alone would take slope and mean of the piece, so that the map of many pieces were too flat. Nor is
    noise what the walls share, which is most of what they leave of a law: each is weighed by the rest.
    """
    maps = [smooth_map(*wall) for wall in walls]
    for _ in range(TURNS if kind == "map" else 0):
        shared = np.nan_to_num(_mean(maps)[0])
        left = [level(e, rest - unit * _read(shared, e)) for e, rest, unit in walls]
        usual = float(np.median([spread_of(rest) for rest in left]))
        each = [with_variance(replace(e, variance=0 * r), r, usual) for (e, *_), r in zip(walls, left, strict=True)]
        found = [smooth_map(e, rest, unit) for e, rest, (*_, unit) in zip(each, left, walls, strict=True)]
        maps = [(shared + value, weight) for value, weight in found]
    return maps


def _read(values: Array, evidence: WallEvidence) -> Array:
    """(t,) a map at the tiles of a wall."""
    return values[evidence.tiles.place[:, 0], evidence.tiles.place[:, 1]]


def smooth_map(evidence: WallEvidence, rest: Array, unit: Array) -> tuple[Array, Array]:
    """Smooth error (rows, columns) in the sensor's unit, NaN where nothing is known, and its weight."""
    rest = level(evidence, rest)
    value, weight = evidence.tiles.image(rest / unit), evidence.tiles.image(unit**2 / evidence.variance)
    known = np.isfinite(value)
    weight = np.where(known, weight, 0.0)
    below = gaussian_filter(weight, SMOOTH)
    smooth = gaussian_filter(np.where(known, value, 0.0) * weight, SMOOTH) / np.maximum(below, 1e-300)
    return np.where(known, smooth, np.nan), weight


def _mean(maps: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    weight = sum(w for _, w in maps)
    total = sum(np.nan_to_num(value) * w for value, w in maps)
    return np.where(weight > 0, total / np.maximum(weight, 1e-300), np.nan), np.asarray(weight)


def _expected(kind: str, maps: list[tuple[Array, Array]], distances: Array, at: float) -> Array:
    """(rows, columns) what the other walls say about one at this distance; 0 where they say nothing."""
    if kind == "map":
        return np.nan_to_num(_mean(maps)[0])
    order = np.argsort(distances)
    place = float(np.interp(at, distances[order], np.arange(len(order))))
    low = int(min(place, len(order) - 1))
    high = min(low + 1, len(order) - 1)
    share = place - low
    first, second = (filled(maps[order[k]][0]) for k in (low, high))
    return (1 - share) * first + share * second


def filled(values: Array) -> Array:
    """The nearest known value where there is none."""
    missing = ~np.isfinite(values)
    if not missing.any() or missing.all():
        return np.nan_to_num(values)
    at = distance_transform_edt(missing, return_distances=False, return_indices=True)
    return values[tuple(at)]
