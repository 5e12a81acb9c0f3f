"""Scatter and drift: what differs from tile to tile, and from recording to recording, and follows no law at all."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.optimize import minimize

from fusion.discrepancy.gauge import Gauge, drift_columns
from fusion.discrepancy.naming.candidates import Candidate
from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.part import FIELD
from fusion.discrepancy.observations import Observations
from fusion.discrepancy.spreads import Left, Spreads, likeliest
from fusion.discrepancy.unknown.unrestricted import Group

Vector = NDArray[np.float64]

MUCH = 4.0  # times the gauge's variance: real scenes (second bounces, bent boards, traced labels), not its own faults
MOST_COLUMNS = 0.7  # of the tiles: with more, what is left says nothing
FAINT = 1e-8  # of the largest direction: rounding
SURE = 10.0  # chi2 by which a drift must be likelier than none: chance has it in one case of some hundreds
FAR = 4.0  # standard deviations beyond which a tile is told of otherwise, and not by the spread of all
SIZES = np.geomspace(1e-3, 1e3, 25)  # of a drift where it shows, over the noise, that are tried


@dataclass(frozen=True)
class Loose:
    """Errors that no law follows, as standard deviations [native unit]; 0 where the gauge does without.

    Attributes:
        scatter: of each tile for itself.
        drift: of a smooth field of the image in each recording.
        uneven: variance of both in recording 0, 1, ... over the usual one; empty where they are even.
    """

    scatter: float = 0.0
    drift: float = 0.0
    uneven: tuple[float, ...] = ()


def loose_of(
    observations: Observations, gauge: Gauge, candidates: Sequence[Candidate], groups: Sequence[Group]
) -> Loose:
    """The two kinds of errors, told apart by how smooth they are.

    All forms and all smooth functions together are taken out first, so that nothing that could have a name is called
    scatter or drift; maps too, where there are recordings enough.
    """
    basis = _spanned(candidates, groups)
    if basis is None:
        return Loose()
    white = gauge.whiten(observations.residual)
    white = white - basis @ (basis.T @ white)
    far = FAR * np.sqrt(inflation(white))
    white = np.clip(white, -far, far)
    seen = gauge.whiten(drift_columns(observations))
    noise, drift = _two_sizes(white, seen - basis @ (basis.T @ seen), len(white) - basis.shape[1])
    alone = len(np.unique(observations.place)) < 2  # it may be off as a law has it
    if noise < MUCH:
        return Loose(0.0, 0.0 if alone else drift)
    found = _spreads(observations, gauge, basis, white)
    return Loose(found.scatter, 0.0 if alone else found.drift, found.uneven)


def _spreads(observations: Observations, gauge: Gauge, basis: Vector, white: Vector) -> Spreads:
    """How large errors beside the gauge are, and in which recordings, from what no law reaches of a residual (n,)."""
    beside = qr(basis)[0][:, basis.shape[1] :]
    left = Left(beside.T @ white, gauge.pulled(beside), drift_columns(observations), observations.place)
    more = max(float(left.white @ left.white) / len(left.white) - 1.0, 1.0)
    start = float(np.sqrt(more * len(left.white) / (left.rough**2).sum()))
    rough = likeliest(left, Spreads(start))
    both = likeliest(left, replace(rough, drift=rough.scatter))
    return both if rough.cost - both.cost > SURE else rough


def _two_sizes(white: Vector, seen: Vector, freedom: int) -> tuple[float, float]:
    """Variance of all directions alike, and standard deviation of the weights of columns (n, k), likeliest together.

    Args:
        freedom: number of independent directions of white (n,).
    """
    values, vectors = np.linalg.eigh(seen.T @ seen)
    told = values > 1e-6 * values[-1]
    values, vectors = values[told], vectors[:, told]
    power = (vectors.T @ (seen.T @ white)) ** 2 / values
    beside, rest = freedom - len(values), float(white @ white - power.sum())

    def cost(logarithms: Vector) -> float:
        noise, drift = np.exp(logarithms)
        both = noise + drift * values
        return float(beside * np.log(noise) + rest / noise + (np.log(both) + power / both).sum())

    alone = float(white @ white) / freedom
    starts = [(alone / (1 + t), alone * t / (1 + t) / float(np.median(values))) for t in SIZES]
    start = min((np.log(pair) for pair in starts), key=cost)
    best = minimize(cost, start, method="Nelder-Mead", options={"xatol": 0.01, "fatol": 0.01})
    without = freedom * (np.log(alone) + 1.0)
    if without - best.fun < SURE:
        return alone, 0.0
    return float(np.exp(best.x[0])), float(np.exp(best.x[1] / 2))


def _spanned(candidates: Sequence[Candidate], groups: Sequence[Group]) -> Vector | None:
    """(n, r) orthonormal columns that span all forms and smooth functions; None where too little is left beside."""
    forms, smooth = [c.basis for c in candidates], [g.basis for g in groups]
    # few recordings: maps with a square for nearly every tile would follow anything; few tiles: so do smooth functions
    unmapped = [c.basis for c in candidates if not c.form.map]
    plain = [c.basis for c in candidates if c.columns.shape[1] < FIELD]
    for bases in ([*forms, *smooth], [*unmapped, *smooth], plain):
        whole = _directions(bases)
        if whole.shape[1] <= MOST_COLUMNS * len(whole):
            return whole
    return None


def _directions(bases: Sequence[Vector]) -> Vector:
    """(n, r) orthonormal columns that span all of them."""
    columns = np.concatenate(bases, axis=1)
    power, directions = np.linalg.eigh(columns.T @ columns)
    kept = power > FAINT * power[-1]
    return np.asarray(columns @ (directions[:, kept] / np.sqrt(power[kept])))
