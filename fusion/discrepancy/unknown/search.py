"""Search: the term of an unknown law that predicts recordings best from the others."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fusion.discrepancy.inference.sizes import orthonormal
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.evidence import gain_elsewhere
from fusion.discrepancy.unknown.families import shapes_of
from fusion.discrepancy.unknown.terms import UnknownTerm
from fusion.recording.ahead import side_by_side

Vector = NDArray[np.float64]

BEST = 2  # terms per kind and variables that are tried further
IN_ALL = 14
FINAL = 24  # forms that are tried on recordings left out
EXACT = 6  # of these, that are computed pixel by pixel
ALIKE = 0.8  # of the gain: a finer wave that has it may be the better one once its period is right
NEARBY = (0.96, 0.98, 1.0, 1.02, 1.04)  # times the period that means of tiles give
SHORTEST = 0.75  # tiles: a tile's mean keeps a fifth of a wave of that length
# what a law may scale with: a variable, its powers, and variables that are as good as it
SCALES = (("depth", (1.0, 2.0, -1.0), ("depth", "range", "disparity")), ("amplitude", (-1.0, -0.5), ("amplitude",)))
WORTH = 0.08  # of the gain: what a further variable or term must bring


class _Tried(NamedTuple):
    """A term, what it gains, and its whitened columns (n, k)."""

    gain: float
    term: UnknownTerm
    columns: Vector


@dataclass(frozen=True)
class TermColumns:
    """Terms in units of the covariance, each computed once however often it is tried.

    Attributes:
        at: variables (n,), as means over tiles.
        data: whose tiles, and how far they may be off.
        exact: columns (n, k) of a term from its values at the pixels, not from those at the means of tiles.
    """

    at: Mapping[str, Vector]
    data: MeasuredTiles
    exact: Callable[[UnknownTerm], Vector]
    _means: dict[UnknownTerm, Vector] = field(default_factory=dict)
    _pixels: dict[UnknownTerm, Vector] = field(default_factory=dict)

    def of_means(self, terms: Sequence[UnknownTerm]) -> list[Vector]:
        """(n, k) of each, whitened in one go."""
        new = [term for term in dict.fromkeys(terms) if term not in self._means]
        blocks = [_sized(term.columns(self.at)) for term in new]
        if blocks:
            ends = np.cumsum([block.shape[1] for block in blocks])
            white = self.data.covariance.whiten(np.concatenate(blocks, axis=1))
            self._means.update(zip(new, np.split(white, ends[:-1], axis=1), strict=True))
        return [self._means[term] for term in terms]

    def at_pixels(self, term: UnknownTerm) -> Vector:
        """(n, k) of one."""
        if term not in self._pixels:
            self._pixels[term] = self.data.covariance.whiten(_sized(self.exact(term)))
        return self._pixels[term]


def best_term(white: Vector, columns: TermColumns) -> UnknownTerm | None:
    """The term that predicts recordings of a vector (n,) best from the others; None when none does."""
    at, place = columns.at, columns.data.observations.place
    singles = _scored([UnknownTerm((shape,)) for name, x in at.items() for shape in shapes_of(name, x)], white, columns)
    if not singles:
        return None
    # a wave may show only where another variable does not hide it: all of them are tried in products too
    waves = [term for _, term, _ in singles if term.shapes[0].kind == "wave"]
    products = _scored(list(_scaled(waves, at)), white, columns)
    kept, scaled = (
        side_by_side(lambda item: _tuned(item, white, columns), _leading(some)) for some in (singles, products)
    )
    leading = [term for _, term, _ in kept]
    tried = kept + scaled + _scored([*_scaled(leading, at), *_curved(leading, at)], white, columns)
    tried = sorted(tried, key=lambda item: -item.gain)[:FINAL]
    # what differs from recording to recording follows any of their differences: only new recordings tell
    tried = sorted(tried, key=lambda item: -gain_elsewhere(item.columns, white, place))
    plain = [item for item in tried[EXACT:] if len(item.term.variables) == 1]
    terms = [term for _, term, _ in (*tried[:EXACT], *plain[:1])]

    def at_pixels(term: UnknownTerm) -> _Tried:
        own = columns.at_pixels(term)
        return _Tried(gain_elsewhere(own, white, place), term, own)

    final = [at_pixels(term) for term in terms]
    final += _finer(
        terms[0], columns.data.observations.patches[0].tiles.side, at_pixels, max(one.gain for one in final)
    )
    gains = [one.gain for one in final]
    best = final[_plainest([one.term for one in final], gains)]
    return best.term if _score(best.columns, white) > 0 and best.gain > 0 else None


def _finer(term: UnknownTerm, side: int, at_pixels: Callable[[UnknownTerm], _Tried], gain: float) -> list[_Tried]:
    """Waves shorter than two tiles, which look alike in their means; only their pixels tell them apart.

    Those that do nearly as well as the wave of this term are taken with their period between those that were tried.
    """
    found, first = [], term.shapes[0]
    for finer in _aliases(term, side):
        if at_pixels(finer).gain < ALIKE * gain:
            continue
        period = finer.shapes[0].number
        other = [replace(term, shapes=(first.tuned(period * part), *term.shapes[1:])) for part in NEARBY]
        found.append(max((at_pixels(one) for one in other), key=lambda item: item.gain))
    return found


def _aliases(term: UnknownTerm, side: int) -> Iterator[UnknownTerm]:
    """The same with a wave that is shorter than two tiles."""
    first = term.shapes[0]
    if first.kind == "wave" and first.variable in ("u", "v"):
        for waves in (1 / side - 1 / first.number, 1 / side + 1 / first.number):
            if waves * SHORTEST * side < 1:
                yield replace(term, shapes=(first.tuned(1 / waves), *term.shapes[1:]))


def _plainest(terms: Sequence[UnknownTerm], gains: Sequence[float]) -> int:
    """The best of those with the fewest variables: a further one that brings little is no part of the law."""
    enough = [k for k, gain in enumerate(gains) if gain >= (1 - WORTH) * max(gains)]
    return min(enough or range(len(gains)), key=lambda k: (len(terms[k].variables), -gains[k]))


def _leading(scored: Sequence[_Tried]) -> list[_Tried]:
    """The best, not too many of one kind."""
    kept: list[_Tried] = []
    taken: dict[tuple[str, ...], int] = {}
    for item in sorted(scored, key=lambda item: -item.gain):
        kind = (item.term.shapes[0].kind, *item.term.variables)
        taken[kind] = taken.get(kind, 0) + 1
        if taken[kind] <= BEST:
            kept.append(item)
    return kept[:IN_ALL]


def _scaled(terms: Sequence[UnknownTerm], at: Mapping[str, Vector]) -> Iterator[UnknownTerm]:
    """Products of terms with powers of the depth and the amplitude."""
    for name, powers, alike in SCALES:
        known = shapes_of(name, at[name]) if name in at else ()
        scales = [shape for shape in known if shape.kind == "power" and shape.number in powers]
        for term in terms:
            if term.variables[0] not in alike:
                yield from (UnknownTerm((*term.shapes, shape)) for shape in scales)


def _curved(terms: Sequence[UnknownTerm], at: Mapping[str, Vector]) -> Iterator[UnknownTerm]:
    """Products of terms with lines and parabolas."""
    for term in terms:
        for name in ("u", "v", "depth", "time"):
            if name in at and name != term.variables[0]:
                low, high = float(np.min(at[name])), float(np.max(at[name]))
                for degree in (1, 2):
                    yield UnknownTerm(term.shapes, name, degree, (low + high) / 2, (high - low) / 2)


def _scored(terms: Sequence[UnknownTerm], white: Vector, columns: TermColumns) -> list[_Tried]:
    """Score, term and whitened columns of each."""
    parts = columns.of_means(terms)
    return [_Tried(_score(part, white), term, part) for term, part in zip(terms, parts, strict=True)]


def _score(columns: Vector, white: Vector) -> float:
    basis = orthonormal(columns)
    return float(((basis.T @ white) ** 2).sum()) - basis.shape[1] * float(np.log(len(white)))


def _tuned(item: _Tried, white: Vector, columns: TermColumns) -> _Tried:
    """With its period or time constant between those that were tried."""
    score, term, _ = item
    first = term.shapes[0]
    if not first.tunable:
        return item

    def other(number: float) -> UnknownTerm:
        return replace(term, shapes=(first.tuned(number), *term.shapes[1:]))

    def loss(number: float) -> float:
        return -_scored([other(number)], white, columns)[0].gain

    near = 0.12 if first.kind != "decay" else 0.6
    bounds = (first.number * (1 - near), first.number * (1 + near))
    found = minimize_scalar(loss, bounds=bounds, method="bounded", options={"maxiter": 9, "xatol": 2e-3 * bounds[0]})
    return _scored([other(float(found.x))], white, columns)[0] if -found.fun > score else item


def _sized(columns: Vector) -> Vector:
    return columns / np.maximum(np.abs(columns).max(axis=0), 1e-12)
