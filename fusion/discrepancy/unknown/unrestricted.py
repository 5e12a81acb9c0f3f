"""The unrestricted model: what smooth functions of everything known could explain, whatever the physics."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.sizes import orthonormal
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.observe.observations import Observations

Matrix = NDArray[np.float64]

SMOOTH = ("depth", "u", "v", "radius", "time", "incidence", "amplitude", "temperature")
KNOTS = 6
WORTH = 0.05  # of the gain of all groups: a group that brings less is not named


@dataclass(frozen=True)
class Group:
    """Columns that depend on the same variables.

    Attributes:
        variables: names as in verdicts.
        basis: (n, r) orthonormal, in units of the covariance.
    """

    variables: tuple[str, ...]
    basis: Matrix


@dataclass(frozen=True)
class UnrestrictedGain:
    """What the unrestricted model explains of a whitened vector.

    Attributes:
        gain: drop of the chi2 beyond what noise alone would give.
        variables: of the groups that bring it, the most telling first.
        fitted: (n,) the explained part, whitened.
    """

    gain: float
    variables: tuple[str, ...]
    fitted: NDArray[np.float64]


def groups_of(observations: Observations, covariance: TileCovariance) -> list[Group]:
    """Main effects of every covariate, and their products with the depth where a law of the image may scale with it."""
    known = covariates(observations)
    depth = known.get("depth")  # not known of tiles of one depth, as of a wall that is faced squarely
    rows: list[tuple[tuple[str, ...], Matrix]] = []
    for name, values in known.items():
        own = _steps(values) if name in ("u", "v") else hats(values, knots_of(values, KNOTS))
        if own.shape[1] > 1:
            rows.append(((name,), own))
            if depth is not None and name != "depth":
                scaled = np.concatenate(
                    [own * (depth / np.median(depth))[:, None] ** power for power in (1, 2)], axis=1
                )
                rows.append(((name, "depth"), scaled))
    return [Group(variables, orthonormal(covariance.whiten(columns))) for variables, columns in rows]


def covariates(observations: Observations) -> dict[str, NDArray[np.float64]]:
    """What laws of any physics may follow smoothly, of every tile (n,): the amplitude by its logarithm."""
    known = {name: observations.variables[name] for name in SMOOTH if name in observations.variables}
    return {name: np.log(np.maximum(x, 1.0)) if name == "amplitude" else x for name, x in known.items()}


def explained(white: NDArray[np.float64], groups: list[Group], known: Matrix) -> UnrestrictedGain:
    """Forward choice of groups, each paying for its columns; `known` (n, k) is orthonormal and explained before."""
    rest = white - known @ (known.T @ white)
    chosen, used, total = known, [], 0.0
    for _ in range(4):
        best = None
        for group in groups:
            basis = _beyond(group.basis, chosen)
            gain = float(((basis.T @ rest) ** 2).sum()) - basis.shape[1] * np.log(len(white))
            if best is None or gain > best[0]:
                best = (gain, group, basis)
        if best is None or best[0] <= max(0.0, WORTH * total):
            break
        gain, group, basis = best
        rest = rest - basis @ (basis.T @ rest)
        chosen = np.concatenate([chosen, basis], axis=1)
        used.append((gain, group.variables))
        total += gain
    names = dict.fromkeys(name for gain, variables in used if gain > WORTH * total for name in variables)
    return UnrestrictedGain(total, tuple(names), white - known @ (known.T @ white) - rest)


def hats(values: NDArray[np.float64], knots: NDArray[np.float64]) -> Matrix:
    """(n, k) piecewise linear functions, which together are a constant too."""
    return np.column_stack([np.interp(values, knots, row) for row in np.eye(len(knots))])


def knots_of(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Quantiles of a variable, at most `count`."""
    return np.unique(np.quantile(values, np.linspace(0, 1, count)))


def _steps(values: NDArray[np.float64]) -> Matrix:
    """(n, k) one column per row or column of tiles."""
    edges = np.arange(0.0, float(np.max(values)) + 16, 16.0)
    columns = [((values >= low) & (values < high)).astype(float) for low, high in pairwise([*edges, np.inf])]
    return np.column_stack([column for column in columns if column.any()])


def _beyond(basis: Matrix, known: Matrix) -> Matrix:
    """What a basis spans beyond known orthonormal columns."""
    if not known.shape[1]:
        return basis
    rest = basis - known @ (known.T @ basis)
    left, values, _ = np.linalg.svd(rest, full_matrices=False)
    return np.asarray(left[:, values > 0.05])
