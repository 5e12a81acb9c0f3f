"""Plainer methods, which the engine is held against: pixels as replicates, stepwise by BIC; lasso; nearest cosine."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.laws.surface import moved_rigidly

Vector = NDArray[np.float64]

TWIST = 1e-3  # [rad], [m] small enough to be linear
MOST_STEPS = 4
MOST_COLUMNS = 12  # a map of the whole image is left to others
FAINT = 1e-3  # of the lasso's largest share


@dataclass(frozen=True)
class Pixelwise:
    """Tiles as if all their pixels were independent and only poses were in doubt.

    Attributes:
        residual: (n,) in units of that error.
        forms: name and columns (n, k) of each candidate, in the same units.
        pixels: of all tiles together.
    """

    residual: Vector
    forms: tuple[tuple[str, NDArray[np.float64]], ...]
    pixels: float

    def rss(self, columns: NDArray[np.float64]) -> float:
        """Sum of squares over pixels that is left, one per pixel within the tiles."""
        left = self.residual - columns @ np.linalg.lstsq(columns, self.residual, rcond=1e-9)[0]
        return float(left @ left) + self.pixels - len(self.residual)


def pixelwise(observations: Observations, candidates: Sequence[Candidate]) -> Pixelwise:
    weights, pixels = [], 0.0
    for _, patch in observations.rows():
        count = patch.tiles.pixels
        variance = patch.tiles.mean((patch.sigma * patch.native) ** 2) / count / len(patch.block.frames)
        weights.append(1 / np.sqrt(variance))
        pixels += float(count.sum())
    weight = np.concatenate(weights)
    poses = _poses(observations) * weight[:, None]
    root = cholesky(np.eye(len(weight)) + poses @ poses.T, lower=True)

    def white(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(solve_triangular(root, (values.T * weight).T, lower=True))

    few = [c for c in candidates if c.columns.shape[1] <= MOST_COLUMNS]
    return Pixelwise(white(observations.residual), tuple((c.name, white(c.columns)) for c in few), pixels)


def stepwise_bic(data: Pixelwise) -> list[str]:
    """Effects in the order in which they lower the Bayesian information criterion of all pixels."""
    names: list[str] = []
    used = np.zeros((len(data.residual), 0))
    best = data.pixels * np.log(data.rss(used) / data.pixels)
    for _ in range(MOST_STEPS):
        tried = []
        for name, columns in data.forms:
            both = np.column_stack([used, columns])
            fit = data.pixels * np.log(data.rss(both) / data.pixels)
            tried.append((fit + _rank(both) * np.log(data.pixels), name, both))
        bic, name, both = min(tried, key=lambda entry: entry[0])
        if bic >= best:
            break
        best, used = bic, both
        names.append(name)
    return list(dict.fromkeys(names))


def lasso(data: Pixelwise) -> list[str]:
    """Effects that the lasso keeps, the largest first; its penalty by the same criterion."""
    owners = [name for name, columns in data.forms for _ in range(columns.shape[1])]
    A = np.concatenate([columns for _, columns in data.forms], axis=1)
    lengths = np.linalg.norm(A, axis=0)
    kept = lengths > 0
    A, owners = A[:, kept] / lengths[kept], [name for name, k in zip(owners, kept, strict=True) if k]
    normal, moment = A.T @ A, A.T @ data.residual
    x, best, chosen = np.zeros(len(moment)), np.inf, np.zeros(len(moment))
    for penalty in np.geomspace(1.0, 1e-3, 25) * np.max(np.abs(moment)):
        x = _descended(normal, moment, penalty, x)
        support = x != 0
        bic = data.pixels * np.log(data.rss(A[:, support]) / data.pixels) + support.sum() * np.log(data.pixels)
        if bic < best:
            best, chosen = bic, x.copy()
    sizes: dict[str, float] = {}
    for name, value in zip(owners, chosen, strict=True):
        sizes[name] = sizes.get(name, 0.0) + abs(float(value))
    least = FAINT * max(sizes.values(), default=0.0)
    return [name for name, size in sorted(sizes.items(), key=lambda entry: -entry[1]) if size > least]


def nearest_cosine(data: Pixelwise) -> list[str]:
    """The effect whose footprint points most like the residual; there always is one."""
    return [max(data.forms, key=lambda form: _explained(form[1], data.residual))[0]] if data.forms else []


def _descended(normal: NDArray[np.float64], moment: Vector, penalty: float, x: Vector, sweeps: int = 60) -> Vector:
    """Coordinate descent on |r - A x|^2 / 2 + penalty |x|_1, columns of unit length."""
    x = x.copy()
    slope = moment - normal @ x
    for _ in range(sweeps):
        change = 0.0
        for j in range(len(x)):
            wanted = slope[j] + x[j]
            new = np.sign(wanted) * max(abs(wanted) - penalty, 0.0)
            if new != x[j]:
                slope -= normal[:, j] * (new - x[j])
                change, x[j] = max(change, abs(new - x[j])), new
        if change < 1e-4 * penalty:
            break
    return x


def _explained(columns: NDArray[np.float64], residual: Vector) -> float:
    lengths = np.linalg.norm(columns, axis=0)
    A = columns[:, lengths > 0] / lengths[lengths > 0]
    fitted = A @ np.linalg.lstsq(A, residual, rcond=1e-6)[0]
    return float(fitted @ fitted)


def _rank(columns: NDArray[np.float64]) -> int:
    lengths = np.linalg.norm(columns, axis=0)
    return int(np.linalg.matrix_rank(columns[:, lengths > 0] / lengths[lengths > 0], tol=1e-6))


def _poses(observations: Observations) -> NDArray[np.float64]:
    """(n, 6 recordings) one stated standard deviation of each recording's pose, per axis."""
    columns = []
    for place in np.unique(observations.place):
        for axis in range(6):
            column = np.zeros(len(observations.residual))
            for rows, patch in observations.rows():
                if patch.block.place == place:
                    size = patch.block.stage.sigma_rad if axis < 3 else patch.block.stage.sigma_m
                    change = moved_rigidly(patch.depth, TWIST * np.eye(6)[axis], patch.view) * patch.native
                    column[rows] = patch.tiles.mean(change) * size / TWIST
            columns.append(column)
    return np.column_stack(columns)
