"""An unknown law as the effect `tabulated`: its values on a grid of what it depends on."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.unknown.terms import UnknownTerm
from fusion.recording.ahead import side_by_side
from fusion.sensor.effects.readout.tabulated import STEEPEST, VARIABLES, Tabulated
from fusion.sensor.laws.table import interpolated

Vector = NDArray[np.float64]

NODES = 25  # along a variable; steps of a wave's sixteenth on top
MOST_NODES = 161
MOST_ENTRIES = 60_000
BEYOND = 0.25  # of the span: so far a formula is believed outside the data


@dataclass(frozen=True)
class TermTables:
    """Terms and the weights (k,) of all their columns, in native units."""

    terms: tuple[UnknownTerm, ...]
    weights: Vector


def pixel_columns(term: UnknownTerm, observations: Observations) -> Vector:
    """(n, k) a term's columns at the pixels, averaged over the tiles."""
    return np.concatenate(side_by_side(lambda patch: _columns(term, patch), observations.patches))


def _columns(term: UnknownTerm, patch: Patch) -> Vector:
    at = {name: np.asarray(VARIABLES[name](patch.depth, patch.view), float) for name in term.variables}
    with np.errstate(all="ignore"):
        values = term.columns(dict(zip(at, np.broadcast_arrays(*at.values()), strict=True)))
    shape = patch.view.camera.shape
    return np.column_stack([patch.tiles.mean(np.broadcast_to(values[..., k], shape)) for k in range(values.shape[-1])])


def table_of(law: TermTables, observations: Observations) -> Tabulated:
    """The effect that adds the law to what the sensor measures."""
    names = tuple(dict.fromkeys(name for term in law.terms for name in term.variables))
    grid = _thinned([_nodes(name, law.terms, observations) for name in names])
    mesh = dict(zip(names, np.meshgrid(*grid, indexing="ij"), strict=True))
    columns = np.concatenate([term.columns(mesh) for term in law.terms], axis=-1)
    return tabulated(names, grid, columns @ law.weights, observations)


def tabulated(names: tuple[str, ...], grid: list[Vector], values: Vector, observations: Observations) -> Tabulated:
    """A table in the sensor's native unit, held inside its bounds."""
    nodes = tuple(tuple(float(x) for x in axis) for axis in grid)
    if observations.patches[0].view.time_of_flight:
        return Tabulated(names, nodes, values=np.clip(values, -1, 1))
    return Tabulated(names, nodes, values_px=np.clip(values, -2, 2))


def joined(own: Tabulated, more: Tabulated) -> Tabulated:
    """Two tables as one over all their variables; errors and shares of missing values add up."""
    names = tuple(dict.fromkeys((*own.variables, *more.variables)))
    grid = _thinned([_union(name, (own, more)) for name in names])
    mesh = dict(zip(names, np.meshgrid(*grid, indexing="ij"), strict=True))
    total: dict[str, Any] = {}
    for field in ("values", "values_px", "missing"):
        tables = [(t, np.asarray(getattr(t, field), float)) for t in (own, more)]
        if any(np.any(table) for _, table in tables):
            total[field] = np.sum([_at(t, table, mesh) for t, table in tables], axis=0)
    if "missing" in total:
        total["missing"] = np.clip(total["missing"], 0.0, 1.0)
    return Tabulated(names, tuple(tuple(map(float, axis)) for axis in grid), **total)


def unit_of(observations: Observations) -> tuple[float, str]:
    """Factor and symbol of native units as people read them."""
    return (1e3, "mm") if observations.patches[0].view.time_of_flight else (1.0, "px")


def _at(table: Tabulated, values: Vector, mesh: dict[str, Vector]) -> Vector:
    like = next(iter(mesh.values()))
    if not values.ndim:
        return np.full(like.shape, float(values))
    return np.asarray(interpolated(values, table.grid, [mesh[name] for name in table.variables]), float)


def _union(name: str, tables: Iterable[Tabulated]) -> Vector:
    nodes = [t.grid[t.variables.index(name)] for t in tables if name in t.variables]
    return np.unique(np.concatenate([np.asarray(axis, float) for axis in nodes]))


def _nodes(name: str, terms: Iterable[UnknownTerm], observations: Observations) -> Vector:
    """Increasing values of a variable, close enough for every function of it."""
    low, high = span_of(name, observations)
    shapes = [shape for term in terms for shape in term.shapes if shape.variable == name]
    count = NODES
    for shape in shapes:
        if shape.kind == "wave":
            count = max(count, int(16 * (high - low) / shape.number) + 1)
    count = min(count, MOST_NODES)
    ratio = low > 0 and high > 4 * low and all(shape.kind != "wave" for shape in shapes)
    nodes = np.geomspace(low, high, count) if ratio else np.linspace(low, high, count)
    for shape in shapes:
        if shape.kind == "step" and low < shape.number < high:
            width = 1e-3 * (high - low)
            if name in ("depth", "range", "disparity"):  # a sharper one could not be undone
                width = max(width, 0.1 / STEEPEST * (1.0 if name == "disparity" else 0.05))
            outside = nodes[np.abs(nodes - shape.number) > 2 * width]
            nodes = np.unique(np.append(outside, [shape.number - width, shape.number + width]))
    return nodes


def span_of(name: str, observations: Observations) -> tuple[float, float]:
    """Smallest and largest value of a variable that the table holds."""
    camera = observations.patches[0].view.camera
    if name in ("u", "v"):
        return 0.0, float((camera.width if name == "u" else camera.height) - 1)
    seen = []
    for patch in observations.patches:
        values = np.broadcast_to(np.asarray(VARIABLES[name](patch.depth, patch.view), float), camera.shape)
        used = values[(patch.tiles.label >= 0) & np.isfinite(values)]
        if used.size:  # a look may be without any tile
            seen += [float(used.min()), float(used.max())]
    low, high = min(seen), max(seen)
    if name in ("amplitude", "disparity", "depth", "range") and low > 0:
        return low / (1 + BEYOND), high * (1 + BEYOND)
    wider = BEYOND * (high - low) if name in ("time", "temperature") else 0.0
    return max(low - wider, 0.0) if low >= 0 else low - wider, high + wider


def _thinned(grid: list[Vector]) -> list[Vector]:
    """Fewer nodes where the table would be too large."""
    while np.prod([float(len(nodes)) for nodes in grid]) > MOST_ENTRIES:
        longest = int(np.argmax([len(nodes) for nodes in grid]))
        nodes = grid[longest]
        grid[longest] = np.unique(np.append(nodes[::2], nodes[-1]))
    return grid
