"""A table without a formula: piecewise linear over one or two variables."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.unknown.table import span_of, tabulated
from fusion.sensor.effects.readout.tabulated import VARIABLES, Tabulated

Vector = NDArray[np.float64]

KNOTS = {1: 14, 2: 5}  # of each variable, by how many there are
IN_IMAGE = ("u", "v", "radius")
IMAGE_KNOTS_PX = 16.0  # as tiles


def smooth_table(
    observations: Observations, wanted: tuple[str, ...]
) -> tuple[tuple[str, ...], Vector, Callable[[Vector], Tabulated]]:
    """Variables that are used, columns (n, k) of their hats, and what makes a table of weights (k,)."""
    names = tuple(name for name in wanted if name in VARIABLES)[:2] or ("u", "v")
    names = tuple(name for name in names if _known(name, observations)) or ("u", "v")
    grid = [_nodes(name, observations, KNOTS[len(names)]) for name in names]
    columns = np.concatenate([_hats(patch, names, grid) for patch in observations.patches])

    def table(weights: Vector) -> Tabulated:
        return tabulated(names, grid, weights.reshape([len(nodes) for nodes in grid]), observations)

    return names, columns, table


def _nodes(name: str, observations: Observations, count: int) -> Vector:
    low, high = span_of(name, observations)
    return np.linspace(low, high, int((high - low) / IMAGE_KNOTS_PX) + 1 if name in IN_IMAGE else count)


def _known(name: str, observations: Observations) -> bool:
    return all(VARIABLES[name](patch.depth, patch.view) is not None for patch in observations.patches)


def _hats(patch: Any, names: tuple[str, ...], grid: list[Vector]) -> Vector:
    """(n, k) mean over the tiles of the products of piecewise linear functions."""
    shape = patch.view.camera.shape
    sides = []
    for name, nodes in zip(names, grid, strict=True):
        x = np.broadcast_to(np.asarray(VARIABLES[name](patch.depth, patch.view), float), shape)
        sides.append([np.interp(x, nodes, row) for row in np.eye(len(nodes))])
    if len(sides) == 1:
        return np.column_stack([patch.tiles.mean(hat) for hat in sides[0]])
    return np.column_stack([patch.tiles.mean(a * b) for a in sides[0] for b in sides[1]])
