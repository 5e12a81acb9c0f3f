"""Law: what no entry of the catalogue explains, as a formula where one is found, and always as a table."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fusion.discrepancy.decisions import REPLICATED
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, TileCovariance
from fusion.discrepancy.naming.evidence import gain_elsewhere, inflation, weights_of
from fusion.discrepancy.naming.search.step import WITHIN
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.unknown.search import WORTH, TermColumns, best_term
from fusion.discrepancy.unknown.smooth import smooth_table
from fusion.discrepancy.unknown.table import TermTables, pixel_columns, table_of, unit_of
from fusion.discrepancy.unknown.terms import UnknownTerm
from fusion.discrepancy.unknown.unrestricted import UnrestrictedGain
from fusion.sensor.effects.readout.tabulated import Tabulated

Vector = NDArray[np.float64]

MOST_TERMS = 3
MOST_VARIABLES = 3
ENOUGH = 0.7  # of what smooth functions explain: a formula that reaches less is no formula of it
TRIED = 2000.0  # about how many forms are tried


@dataclass(frozen=True)
class UnknownLaw:
    """An effect without a name."""

    variables: tuple[str, ...]  # what it depends on, the most telling first
    text: str  # its form in words and numbers
    simple: bool  # True for a formula, False for a table alone
    table: Tabulated  # the same as an effect of the sensor
    footprint: Vector  # (n,) what it changes, in units of the covariance
    native: Vector  # (n,) the same in native units
    gain: float  # drop of the chi2
    held_out: float  # drop of the chi2 in recordings left out in turn
    probability: float  # that noise alone does this, over all forms tried
    std: float  # of its size, as a share of it
    score: float = 0.0  # the gain less the price of its freedom, and of the choice among all forms tried

    @property
    def replicated(self) -> bool:
        """True when recordings that took no part in the fit show it too."""
        return self.held_out >= REPLICATED * self.gain


def law_of(
    white: Vector, observations: Observations, covariance: TileCovariance, found: UnrestrictedGain
) -> UnknownLaw:
    """The law behind a leftover.

    Args:
        white: (n,) what named effects leave, in units of the covariance.
        found: what smooth functions explain of it.
    """
    terms, left = _terms(white, observations, covariance)
    if terms and float(white @ white - left @ left) >= ENOUGH * found.gain:
        return _formula(terms, white, observations, covariance)
    return _table(white, observations, covariance, found)


def _terms(white: Vector, observations: Observations, covariance: TileCovariance) -> tuple[list[UnknownTerm], Vector]:
    """The terms of a formula, each the best beside the others, and what they leave (n,)."""
    exact = partial(pixel_columns, observations=observations)
    seen = TermColumns(observations.variables, MeasuredTiles(observations, covariance), exact)

    def left_by(terms: Sequence[UnknownTerm]) -> Vector:
        if not terms:
            return white
        columns = np.concatenate([seen.at_pixels(term) for term in terms], axis=1)
        return np.asarray(white - columns @ np.linalg.lstsq(columns, white, rcond=None)[0])

    def beside(others: Sequence[UnknownTerm]) -> UnknownTerm | None:
        return best_term(left_by(others), seen)

    terms: list[UnknownTerm] = []
    left = white
    while len(terms) < MOST_TERMS:
        more = beside(terms)
        if more is None:
            break
        longer = [*terms, more]
        for k in range(len(terms)):  # what was best alone need not be the best beside the others
            other = beside([*longer[:k], *longer[k + 1 :]])
            tried = longer if other is None else [*longer[:k], other, *longer[k + 1 :]]
            longer = min(longer, tried, key=lambda some: float((left_by(some) ** 2).sum()))
        rest = left_by(longer)
        worth = not terms or float(left @ left - rest @ rest) >= WORTH * float(white @ white - left @ left)
        if not worth or len({name for term in longer for name in term.variables}) > MOST_VARIABLES:
            break
        terms, left = longer, rest
    return terms, left


def _formula(
    terms: Sequence[UnknownTerm], white: Vector, observations: Observations, covariance: TileCovariance
) -> UnknownLaw:
    columns = np.concatenate([pixel_columns(term, observations) for term in terms], axis=1)
    sizes = np.maximum(np.abs(columns).max(axis=0), 1e-12)
    columns = columns / sizes
    weights = np.asarray(np.linalg.lstsq(covariance.whiten(columns), white, rcond=1e-9)[0], float)
    table = table_of(TermTables(tuple(terms), weights / sizes), observations)
    tuned = sum(shape.tunable for term in terms for shape in term.shapes)
    variables = tuple(dict.fromkeys(name for term in terms for name in term.variables))
    ends = np.cumsum([0, *(_width(term, observations) for term in terms)])
    unit, symbol = unit_of(observations)
    parts = []
    for k, term in enumerate(terms):
        own = slice(ends[k], ends[k + 1])
        rms = float(np.sqrt(np.mean((columns[:, own] @ weights[own]) ** 2)))
        parts.append(f"{term.text()} with an rms of {rms * unit:.3g} {symbol}")
    data = MeasuredTiles(observations, covariance)
    law = _law((variables, " + ".join(parts), True, table), (columns, weights), white, data)
    price = (len(weights) + tuned) * np.log(len(white)) + 2 * len(terms) * np.log(TRIED)
    return replace(law, score=float(law.gain - price))


def _table(
    white: Vector, observations: Observations, covariance: TileCovariance, found: UnrestrictedGain
) -> UnknownLaw:
    variables, columns, table_from = smooth_table(observations, found.variables)
    weights = weights_of(covariance.whiten(columns), white)
    unit, symbol = unit_of(observations)
    rms = float(np.sqrt(np.mean((columns @ weights) ** 2))) * unit
    text = f"no simple formula; a table over {' and '.join(variables)} with an rms of {rms:.3g} {symbol}"
    data = MeasuredTiles(observations, covariance)
    return _law((variables, text, False, table_from(weights)), (columns, weights), white, data)


def _law(what: Any, fit: tuple[Vector, Vector], white: Vector, data: MeasuredTiles) -> UnknownLaw:
    variables, text, simple, table = what
    (columns, weights), (observations, covariance) = fit, data
    own = covariance.whiten(columns)
    native, footprint = columns @ weights, own @ weights
    gain = float(white @ white - ((white - footprint) ** 2).sum())
    inflated = inflation(white - footprint)
    probability = float(min(1.0, TRIED * chdtrc(columns.shape[1], max(gain, 0.0) / inflated)))
    held_out = _elsewhere(variables, own, white, observations)
    std = float(np.sqrt(inflated / max(gain, 1e-9)))
    return UnknownLaw(variables, text, simple, table, footprint, native, gain, held_out, probability, std)


def _elsewhere(variables: Sequence[str], own: Vector, white: Vector, observations: Observations) -> float:
    """Drop of the chi2 in recordings left out; one alone tells nothing, but of what changes while it goes on.

    Nor do several of what each of them has one value of: whatever else was set up anew with them may be the cause.
    """
    known = observations.variables
    if not all(name in known and _varies(known[name], observations.place) for name in variables):
        return 0.0
    if len(np.unique(observations.place)) > 1:
        return gain_elsewhere(own, white, observations.place)
    changes = len(np.unique(observations.block_number)) > 1 and set(variables) & set(WITHIN)
    return gain_elsewhere(own, white, observations.block_number) if changes else 0.0


def _varies(values: Vector, place: NDArray[np.intp]) -> bool:
    """True where a variable (n,) of tiles has more than one value in any recording."""
    apart = max(float(np.ptp(values[place == g])) for g in np.unique(place))
    return apart > 1e-6 * float(np.ptp(values))


def _width(term: UnknownTerm, observations: Observations) -> int:
    return int(term.columns({name: np.ones(1) for name in term.variables}).shape[-1])
